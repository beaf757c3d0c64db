// What a broker holds for the sessions of another one: heap, without sockets.
//
//     cmake --preset release && cmake --build --preset release --target romano_mirror_bench
//     build/release/bin/romano_mirror_bench

#include <benchmark/benchmark.h>
#include <malloc.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "overlay/member/member.h"
#include "romano/mqttsn/codec.h"

namespace {

using namespace romano;
using namespace std::chrono_literals;
using overlay::Envelope;
using overlay::Member;
using overlay::MemberActions;

Endpoint endpoint(std::uint8_t net, std::uint32_t host) {
    return {.address = {net, static_cast<std::uint8_t>(host >> 16U),
                        static_cast<std::uint8_t>(host >> 8U), static_cast<std::uint8_t>(host)},
            .port = 1883,
            .family = Endpoint::Family::ipv4};
}

/// Two brokers in virtual time, a millisecond a step. Clients talk to the first.
class Pair {
public:
    Pair() {
        for (std::uint32_t i = 0; i < brokers_.size(); ++i) {
            overlay::MemberOptions options;
            options.name = "b" + std::to_string(i + 1);
            options.incarnation = 1;
            options.home_addresses = {endpoint(10, i + 1)};
            options.broker.limits.sessions = 200'000;
            brokers_[i].member = std::make_unique<Member>(options, i + 1);
            brokers_[i].member->on_address(now_, endpoint(10, i + 1), true, brokers_[i].actions);
        }
    }

    template <typename Message>
    void hears(std::uint32_t client, const Message& message) {
        std::array<std::uint8_t, 256> room{};
        const std::size_t size = mqttsn::encode(message, room);
        brokers_[0].member->on_datagram(now_, endpoint(10, 1), endpoint(11, client),
                                        Bytes{room}.first(size), brokers_[0].actions);
    }

    void step() {
        now_ += 1ms;
        auto inboxes =
            std::array{std::exchange(brokers_[0].inbox, {}), std::exchange(brokers_[1].inbox, {})};
        for (std::size_t i = 0; i < brokers_.size(); ++i) {
            auto& [member, actions, inbox] = brokers_[i];
            for (const Envelope& each : inboxes[i]) member->on_peer_message(now_, each, actions);
            if (now_ >= member->next_wakeup()) member->on_tick(now_, actions);
            member->before_sending(now_, actions);
            for (overlay::Outgoing& each : actions.peers) {
                brokers_[1 - i].inbox.push_back({member->log(), std::move(each.message)});
            }
            actions.clear();
        }
    }
    void run_for(Duration time) {
        for (const Instant end = now_ + time; now_ < end;) step();
    }

    /// Of the first at the second; null when that knows of none.
    [[nodiscard]] const broker::Mirror* mirror() const {
        const auto& logs = brokers_[1].member->cluster().peer_logs();
        const auto held = logs.find(brokers_[0].member->log());
        return held == logs.end() ? nullptr : &held->second.mirror();
    }
    /// What is there from now on is the second one's.
    void drop_the_first() {
        brokers_[0] = {};
        brokers_[1].inbox = {};
    }

private:
    struct Broker {
        std::unique_ptr<Member> member;
        MemberActions actions;
        std::vector<Envelope> inbox;
    };
    std::array<Broker, 2> brokers_;
    Instant now_{1s};
};

std::size_t heap() {
    const auto all = mallinfo2();
    return all.uordblks + all.hblkhd;
}

struct Held {
    std::size_t mirror = 0;  // alone
    std::size_t broker = 0;  // all of it, its mirror included
};

/// By a broker whose peer has so many sessions, each with one subscription; empty when they did not
/// come.
std::optional<Held> held_of(std::uint32_t sessions) {
    const std::size_t before = heap();
    Pair pair;
    pair.run_for(5s);
    for (std::uint32_t i = 0; i < sessions; ++i) {
        const std::string id = "robot/" + std::to_string(i);
        pair.hears(i, mqttsn::Connect{false, true, mqttsn::protocol_id, 0, id});
        pair.hears(i, mqttsn::Subscribe{false,
                                        mqttsn::Qos::at_least_once,
                                        mqttsn::MsgId{1},
                                        {mqttsn::TopicIdType::normal, id, mqttsn::no_topic_id}});
        if (i % 50 == 0) pair.step();
    }
    pair.run_for(5s);
    const broker::Mirror* mirror = pair.mirror();
    if (mirror == nullptr || mirror->size() != sessions) return std::nullopt;
    Held held;
    const std::size_t before_copy = heap();
    {
        const broker::Mirror copy = *mirror;
        held.mirror = heap() - before_copy;
    }
    pair.drop_the_first();
    held.broker = heap() - before;
    return held;
}

void sessions_of_a_peer(benchmark::State& state) {
    const auto sessions = static_cast<std::uint32_t>(state.range(0));
    for ([[maybe_unused]] auto _ : state) {
        const auto without = held_of(0);
        const auto with = held_of(sessions);
        if (!without || !with) return state.SkipWithError("the sessions did not come");
        const auto each = [sessions](std::size_t octets) {
            return static_cast<double>(octets) / sessions;
        };
        state.counters["mirror_octets_each"] = each(with->mirror - without->mirror);
        state.counters["octets_each"] = each(with->broker - without->broker);
        state.counters["megaoctets"] = static_cast<double>(with->broker) / 1e6;
    }
}
BENCHMARK(sessions_of_a_peer)
    ->Arg(1'000)
    ->Arg(100'000)
    ->Unit(benchmark::kMillisecond)
    ->Iterations(1);

}  // namespace

BENCHMARK_MAIN();
