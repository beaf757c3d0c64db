#include "experiments/paper/paper_run.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <numeric>
#include <ratio>
#include <stdexcept>
#include <string>

#include "overlay/radio/layout.h"
#include "overlay/radio/radio_network.h"
#include "overlay/sim/lone_world.h"
#include "overlay/sim/seed.h"

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;
using mqttsn::Qos;

constexpr std::size_t server = 0;  // its index in the world
constexpr double delay_rate = 20;  // messages a second
constexpr Duration quiet = 5s;     // nothing came for so long: nothing is on its way

/// As ROMANO ids: the last eight characters of an address.
std::string name_of(std::size_t robot) {
    std::string name = std::to_string(robot + 1);
    return std::string(8 - name.size(), '0') + name;
}

struct AirTimes {
    double router_s;
    double robots_s;
};

double seconds_of(const lowpan::Air& air) {
    return static_cast<double>(lowpan::air_time_ns(air)) / std::nano::den;
}

class Testbed {
public:
    explicit Testbed(const PaperCell& cell) : world_(cell.seed) {
        sim::RobotOptions script;
        script.name = "server";
        world_.add_robot(script);
        radio::RadioOptions options;
        options.router_baud = cell.router_baud;
        options.cells.resize(1);
        options.cells[0].channel = cell.channel;
        for (std::size_t i = 0; i < cell.robots; ++i) {
            sim::RobotOptions robot;
            robot.name = name_of(i);
            robot.subscriptions = {{robot.name, Qos::at_most_once}, {"common", Qos::at_most_once}};
            const sim::Robot& added = world_.add_robot(robot);
            options.cells[0].robots.push_back(
                {added.options().address, radio::place_around({}, i, cell.robots)});
        }
        network_.emplace(world_, options);
        for (std::size_t i = 0; i < world_.robot_count(); ++i) world_.robot(i).start();
        const auto ready = [&] {
            return world_.robots_are_idle() &&
                   world_.ledger().subscriptions.size() == 2 * cell.robots;
        };
        if (!world_.run_until(ready, 60s)) {
            throw std::runtime_error("the robots of a cell did not connect within a minute");
        }
        // The server learns the topic ids. When it begins differs from seed to seed.
        for (std::size_t i = 0; i < cell.robots; ++i) publish(name_of(i));
        publish("common");
        Random random(sim::seed_of(cell.seed, "beginning"));
        world_.run_for(1s + random.between(0s, 1s));
        first_ = world_.robot(server).published() + 1;
    }

    /// At an even rate; then it waits for what is still on its way.
    template <typename TopicOf>
    void publish(std::size_t messages, double rate, TopicOf topic_of) {
        const Instant begin = world_.now();
        for (std::size_t i = 0; i < messages; ++i) {
            publish(topic_of(i));
            const std::chrono::duration<double> due{static_cast<double>(i + 1) / rate};
            world_.run_for(begin + std::chrono::duration_cast<Duration>(due) - world_.now());
        }
        published_until_ = world_.now();
        std::size_t before = 0;
        do {
            before = world_.ledger().receptions.size();
            world_.run_for(quiet);
        } while (world_.ledger().receptions.size() > before);
    }

    /// The messages of the experiment that came, numbered from 0.
    template <typename OnReception>
    void each_reception(OnReception on_reception) const {
        for (const sim::Reception& reception : world_.ledger().receptions) {
            if (reception.number < first_) continue;
            const auto& sent = world_.ledger().sent.at({"server", reception.number});
            on_reception(reception.number - first_, reception, sent.at);
        }
    }
    [[nodiscard]] std::size_t published_before(Instant time) const {
        std::size_t count = 0;
        for (const auto& [key, sent] : world_.ledger().sent) {
            count += key.second >= first_ && sent.at < time ? 1U : 0U;
        }
        return count;
    }
    [[nodiscard]] AirTimes air() const {
        return {seconds_of(network_->sent_by_router(0)), seconds_of(network_->sent_by_robots(0))};
    }
    [[nodiscard]] Instant now() const { return world_.now(); }
    [[nodiscard]] Instant published_until() const { return published_until_; }
    [[nodiscard]] std::optional<Instant> first_overflow() const {
        return network_->first_overflow();
    }
    [[nodiscard]] std::uint64_t frames_given_up() const { return network_->counters().given_up; }

private:
    void publish(const std::string& topic) {
        (void)world_.robot(server).publish(topic, Qos::at_most_once);
    }

    sim::LoneWorld world_;
    std::optional<radio::RadioNetwork> network_;
    std::uint32_t first_ = 0;
    Instant published_until_{};
};

}  // namespace

DeliveryRun delivery_run(const PaperCell& cell, double rate, std::size_t messages) {
    Testbed testbed(cell);
    const Instant begin = testbed.now();
    const std::uint64_t given_up_before = testbed.frames_given_up();
    const AirTimes air_before = testbed.air();
    testbed.publish(messages, rate, [&](std::size_t i) { return name_of(i % cell.robots); });
    DeliveryRun run;
    run.sent = messages;
    run.given_up_on_air = testbed.frames_given_up() - given_up_before;
    run.lasted_s = std::chrono::duration<double>(testbed.now() - begin).count();
    run.router_air_s = testbed.air().router_s - air_before.router_s;
    run.robots_air_s = testbed.air().robots_s - air_before.robots_s;
    const auto overflow = testbed.first_overflow();
    if (overflow) run.overflow_after = testbed.published_before(*overflow);
    const std::size_t accepted = run.overflow_after.value_or(messages);
    std::size_t while_full = 0;
    testbed.each_reception([&](std::size_t number, const sim::Reception& reception, Instant) {
        ++run.delivered;
        if (number < accepted) ++run.delivered_if_it_stops;
        if (overflow && reception.at >= *overflow && reception.at < testbed.published_until()) {
            ++while_full;
        }
    });
    if (overflow) {
        const std::chrono::duration<double> span = testbed.published_until() - *overflow;
        if (span >= 1s) run.carried_per_s = static_cast<double>(while_full) / span.count();
    }
    return run;
}

std::vector<RobotDelay> delay_run(const PaperCell& cell, std::size_t messages) {
    Testbed testbed(cell);
    testbed.publish(messages, delay_rate, [](std::size_t) { return std::string{"common"}; });
    std::map<std::string, std::vector<double>> delays_ms;
    testbed.each_reception([&](std::size_t, const sim::Reception& reception, Instant sent) {
        delays_ms[reception.subscriber].push_back(
            std::chrono::duration<double, std::milli>(reception.at - sent).count());
    });
    std::vector<RobotDelay> robots;
    for (const auto& [name, delays] : delays_ms) {
        const auto [least, most] = std::ranges::minmax(delays);
        const double sum = std::accumulate(delays.begin(), delays.end(), 0.0);
        robots.push_back({least, sum / static_cast<double>(delays.size()), most});
    }
    std::ranges::sort(robots, {}, &RobotDelay::mean);  // the broker's order is its own
    return robots;
}

}  // namespace romano::experiments
