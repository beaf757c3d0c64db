// The channel against what was measured of ns-3's 802.15.4 with 6LoWPAN, and of its duplicates.
#include "overlay/radio/channel.h"

#include <gtest/gtest.h>

#include <cmath>
#include <deque>
#include <map>

namespace romano::lowpan::channel_test {
namespace {

constexpr std::int64_t ms = 1'000'000;
constexpr std::int64_t s = 1'000 * ms;
constexpr std::size_t publish = 39;  // octets of an MQTT-SN PUBLISH with the paper's 32
constexpr double quiet_dbm = -93;
constexpr Device everybody{0, most_robots + 1};

/// Senders with queues on one channel, driven by hand.
class Air {
public:
    explicit Air(const std::vector<CellPlan>& cells, std::uint64_t seed = 1)
        : channel_(cells, 0, quiet_dbm, seed,
                   {[this](Device from, Device to) { return dbm(from, to); },
                    [this](Device at, Device, const std::vector<std::uint8_t>& octets) {
                        received_[at].push_back(now_);
                        last_size = octets.size();
                    },
                    [this](Device device) { done_.push_back(device); }}) {}

    void at(std::int64_t when, Device from, Device to, std::size_t octets = publish) {
        plan_.emplace(when, Send{from, to, octets});
    }
    void run_until(std::int64_t end) {
        while (true) {
            const std::int64_t planned = plan_.empty() ? INT64_MAX : plan_.begin()->first;
            const std::int64_t next = std::min(planned, channel_.next_wakeup_ns());
            if (next > end) break;
            now_ = next;
            channel_.run_until(now_);
            while (!plan_.empty() && plan_.begin()->first <= now_) {
                const Send send = plan_.begin()->second;
                plan_.erase(plan_.begin());
                waiting_[send.from].push_back(send);
                if (waiting_[send.from].size() == 1) begin(send);
            }
            while (!done_.empty()) {
                auto& queue = waiting_[done_.front()];
                done_.pop_front();
                queue.pop_front();
                if (!queue.empty()) begin(queue.front());
            }
        }
    }

    [[nodiscard]] const std::vector<std::int64_t>& received(Device at) { return received_[at]; }
    [[nodiscard]] std::size_t received_in_all() const {
        std::size_t sum = 0;
        for (const auto& [device, times] : received_) sum += times.size();
        return sum;
    }
    [[nodiscard]] const Counters& counters() const { return channel_.counters(); }

    std::function<double(Device, Device)> dbm = [](Device, Device) { return -50.0; };
    std::size_t last_size = 0;

private:
    struct Send {
        Device from;
        Device to;
        std::size_t octets;
    };
    void begin(const Send& send) {
        const std::vector<std::uint8_t> datagram(send.octets, 'x');
        if (send.to == everybody) {
            channel_.broadcast(now_, send.from, datagram);
        } else {
            channel_.send(now_, send.from, send.to, datagram);
        }
    }

    std::int64_t now_ = 0;
    std::multimap<std::int64_t, Send> plan_;
    std::map<Device, std::deque<Send>> waiting_;
    std::map<Device, std::vector<std::int64_t>> received_;
    std::deque<Device> done_;
    Channel channel_;
};

std::size_t router_to_robots(std::int64_t rate, std::size_t count) {
    Air air({{26, 5}});
    for (std::size_t i = 0; i < count; ++i) {
        const auto at = s + static_cast<std::int64_t>(i) * s / rate;
        air.at(at, {0, 0}, {0, 1 + i % 5});
    }
    air.run_until(s + static_cast<std::int64_t>(count) * s / rate);
    return air.received_in_all();
}

TEST(Channel, AFrameIsTheDatagramAnd21OctetsAndItsAcknowledgement5) {
    Air air({{26, 1}});
    air.at(s, {0, 0}, {0, 1});
    air.run_until(2 * s);
    EXPECT_EQ(air.counters().frames, 2U);
    EXPECT_EQ(air.counters().air_octets, publish + 21 + 5);
}

TEST(Channel, AFrameOf60OctetsIsOnTheAirFor2Point1Ms) {
    EXPECT_EQ(air_time_ns({1, 60}), 66 * 32'000);
}

TEST(Channel, ABroadcastIsOneFrameThatEverybodyOfTheCellHearsAndNobodyAcknowledges) {
    Air air({{26, 5}, {26, 1}});
    air.at(s, {0, 1}, everybody);
    air.run_until(2 * s);
    EXPECT_EQ(air.counters().frames, 1U);
    EXPECT_EQ(air.received_in_all(), 5U);
    EXPECT_TRUE(air.received({0, 1}).empty());
    EXPECT_TRUE(air.received({1, 1}).empty());
}

TEST(Channel, OneFrameTakes100OctetsAndTwoTake200) {
    Air air({{26, 1}});
    air.at(s, {0, 0}, {0, 1}, 100);
    air.run_until(2 * s);
    EXPECT_EQ(air.counters().frames, 2U);  // with the acknowledgement
    EXPECT_EQ(air.last_size, 100U);
    air.at(3 * s, {0, 0}, {0, 1}, 200);
    air.run_until(4 * s);
    EXPECT_EQ(air.counters().frames, 6U);
    EXPECT_EQ(air.last_size, 200U);
}

TEST(Channel, ABorderRouterCarries200MessagesASecondAndNot220) {
    EXPECT_GE(router_to_robots(200, 1'000), 995U);
    EXPECT_NEAR(static_cast<double>(router_to_robots(220, 1'000)) / 1'000, 0.95, 0.02);
    EXPECT_NEAR(static_cast<double>(router_to_robots(400, 2'000)) / 5, 210, 4);  // 5 s
}

TEST(Channel, FiftyRobotsReachTheBorderRouterAt200MessagesASecond) {
    Air air({{26, 50}});
    constexpr std::size_t count = 1'000;
    for (std::size_t i = 0; i < count; ++i) {
        const auto jitter = static_cast<std::int64_t>((i * 7'919) % 4'000) * ms / 1'000;
        air.at(s + static_cast<std::int64_t>(i) * 5 * ms + jitter, {0, 1 + i % 50}, {0, 0});
    }
    air.run_until(7 * s);
    EXPECT_NEAR(static_cast<double>(air.received_in_all()) / count, 0.993, 0.01);
}

TEST(Channel, ABurstToFiveRobotsComesOneAfterTheOther) {
    constexpr std::size_t bursts = 100;
    Air air({{26, 5}});
    for (std::size_t i = 0; i < bursts; ++i) {
        for (std::size_t robot = 1; robot <= 5; ++robot) {
            air.at(s + static_cast<std::int64_t>(i) * 100 * ms, {0, 0}, {0, robot});
        }
    }
    air.run_until(s + bursts * 100 * ms);
    // Measured between sockets in real time: 4.4, 8.9, 13.8, 18.7, 23.6 ms, but 3.7 for a message
    // alone. What a burst's first has more than that, all of it has; this channel knows no cause
    // for it, so the first is held against a message alone, and the others by their steps. A
    // backoff is 0 to 7 times 0.32 ms: over 100 bursts here and there a step differs by 0.1 ms (1
    // sigma).
    constexpr double measured_single_ms = 3.7;
    constexpr double measured_step_ms = (23.6 - 4.4) / 4;
    double before_ms = measured_single_ms - measured_step_ms;
    for (std::size_t robot = 1; robot <= 5; ++robot) {
        const auto& times = air.received({0, robot});
        ASSERT_EQ(times.size(), bursts);
        double mean_ms = 0;
        for (std::size_t i = 0; i < bursts; ++i) {
            mean_ms += static_cast<double>(times[i] - s - static_cast<std::int64_t>(i) * 100 * ms);
        }
        mean_ms /= static_cast<double>(bursts * ms);
        EXPECT_NEAR(mean_ms - before_ms, measured_step_ms, 0.25) << "robot " << robot;
        before_ms = mean_ms;
    }
}

TEST(Channel, HalfOfTheFramesAreLostAtMinus94Dbm) {
    Air air({{26, 1}});
    air.dbm = [](Device from, Device) { return from.number == 0 ? -94.13 : -50.0; };
    constexpr std::size_t count = 500;
    for (std::size_t i = 0; i < count; ++i) {
        air.at(s + static_cast<std::int64_t>(i) * 50 * ms, {0, 0}, {0, 1});
    }
    air.run_until(40 * s);
    // Each datagram is repeated up to three times: 1 + 1/2 + 1/4 + 1/8 attempts, each acknowledged
    // one time in two.
    const auto attempts = static_cast<double>(air.counters().frames - air.received_in_all());
    EXPECT_NEAR(attempts / count, 1.875, 0.2);
    EXPECT_NEAR(static_cast<double>(air.received_in_all()) / count, 0.9375, 0.04);
}

TEST(Channel, WhatIsRepeatedForALostAcknowledgementComesOnce) {
    Air air({{26, 1}});
    air.dbm = [](Device from, Device) { return from.number == 0 ? -50.0 : -120.0; };
    air.at(s, {0, 0}, {0, 1});
    air.run_until(2 * s);
    EXPECT_EQ(air.received_in_all(), 1U);
    EXPECT_EQ(air.counters().duplicates, 3U);
    EXPECT_EQ(air.counters().given_up, 1U);
}

std::size_t two_cells(unsigned first, unsigned second) {
    Air air({{first, 1}, {second, 1}});
    constexpr std::int64_t rate = 200;  // each
    for (std::int64_t i = 0; i < 5 * rate; ++i) {
        for (const std::size_t cell : {0U, 1U}) air.at(s + i * s / rate, {cell, 0}, {cell, 1});
    }
    air.run_until(6 * s);
    return air.received_in_all();
}

TEST(Channel, CellsOnOneChannelShareItAndOthersDoNot) {
    EXPECT_GE(two_cells(11, 26), 1'990U);
    const std::size_t shared = two_cells(20, 20);
    EXPECT_LE(shared, 1'700U);
    EXPECT_GE(shared, 1'000U);
}

}  // namespace
}  // namespace romano::lowpan::channel_test
