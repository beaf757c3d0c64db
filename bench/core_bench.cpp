// What a message costs in the broker core, without sockets: publish path, fan-out, topic match.
//
//     cmake --preset release && cmake --build --preset release --target romano_core_bench
//     build/release/bin/romano_core_bench

#include <benchmark/benchmark.h>
#include <malloc.h>

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "broker/core/broker_core.h"
#include "broker/core/topic_tree.h"
#include "romano/mqttsn/codec.h"

namespace {

using namespace romano;
using namespace romano::broker;
using namespace romano::mqttsn;
using namespace std::chrono_literals;
using Octets = std::vector<std::uint8_t>;
namespace wire = romano::mqttsn;

template <typename M>
Octets encoded(const M& message) {
    Octets octets(2048);
    octets.resize(wire::encode(message, octets));
    return octets;
}

Endpoint endpoint(std::uint32_t number) {
    return {.address = {10, static_cast<std::uint8_t>(number >> 16U),
                        static_cast<std::uint8_t>(number >> 8U), static_cast<std::uint8_t>(number)},
            .port = 1883,
            .family = Endpoint::Family::ipv4};
}

/// A broker with clients that connect, subscribe and register.
class Bench {
public:
    explicit Bench(bool writes_log = false) : core_(options(writes_log), 1) {}

    void connects(std::uint32_t client) {
        const std::string id = "client" + std::to_string(client);
        hears(client, encoded(Connect{false, true, protocol_id, 0, id}));
    }
    void subscribes(std::uint32_t client, std::string_view filter, Qos qos) {
        hears(client,
              encoded(Subscribe{false, qos, MsgId{1}, {TopicIdType::normal, filter, no_topic_id}}));
    }
    /// The topic's id is the client's first.
    void registers(std::uint32_t client, std::string_view name) {
        hears(client, encoded(Register{no_topic_id, MsgId{1}, name}));
    }
    void hears(std::uint32_t client, Bytes datagram) {
        out_.clear();
        core_.on_datagram(now_, endpoint(0xFFFFFF), endpoint(client), datagram, out_);
    }
    [[nodiscard]] const Actions& out() const { return out_; }
    void passes(Duration time) { now_ += time; }

private:
    static BrokerOptions options(bool writes_log) {
        BrokerOptions made;
        made.writes_log = writes_log;
        made.limits.sessions = 50'000;
        return made;
    }

    BrokerCore core_;
    Instant now_{1s};
    Actions out_;
};

Octets publish(Qos qos, std::uint16_t msg_id, std::uint16_t topic = 1) {
    static const Octets payload(32, 'x');
    return encoded(
        Publish{false, qos, false, TopicIdType::normal, TopicId{topic}, MsgId{msg_id}, payload});
}

/// One publisher and one subscriber among `sessions` pairs, each with a topic of its own.
void qos0_one_to_one(benchmark::State& state) {
    Bench bench;
    const auto pairs = static_cast<std::uint32_t>(state.range(0));
    for (std::uint32_t i = 0; i < pairs; ++i) {
        const std::string topic = "robot/" + std::to_string(i) + "/pose";
        bench.connects(2 * i);
        bench.connects(2 * i + 1);
        bench.registers(2 * i, topic);
        bench.subscribes(2 * i + 1, topic, Qos::at_most_once);
    }
    const Octets datagram = publish(Qos::at_most_once, 0);
    std::uint32_t at = 0;
    for ([[maybe_unused]] auto _ : state) {
        bench.hears(2 * at, datagram);
        benchmark::DoNotOptimize(bench.out().list().data());
        at = (at + 7919) % pairs;
    }
    state.SetItemsProcessed(state.iterations());
}
BENCHMARK(qos0_one_to_one)->Arg(1)->Arg(5)->Arg(5'000);

void qos0_fan_out(benchmark::State& state) {
    Bench bench;
    bench.connects(0);
    bench.registers(0, "common");
    const auto subscribers = static_cast<std::uint32_t>(state.range(0));
    for (std::uint32_t i = 1; i <= subscribers; ++i) {
        bench.connects(i);
        bench.subscribes(i, "common", Qos::at_most_once);
    }
    const Octets datagram = publish(Qos::at_most_once, 0);
    for ([[maybe_unused]] auto _ : state) bench.hears(0, datagram);
    state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(qos0_fan_out)->Arg(50)->Arg(1'000);

void qos0_wildcard(benchmark::State& state) {
    Bench bench;
    bench.connects(0);
    bench.connects(1);
    bench.subscribes(1, "robot/+/pose", Qos::at_most_once);
    bench.registers(0, "robot/7/pose");
    const Octets datagram = publish(Qos::at_most_once, 0);
    bench.hears(0, datagram);
    bench.hears(1, encoded(Regack{TopicId{1}, MsgId{1}, ReturnCode::accepted}));
    for ([[maybe_unused]] auto _ : state) bench.hears(0, datagram);
    state.SetItemsProcessed(state.iterations());
}
BENCHMARK(qos0_wildcard);

/// PUBLISH, PUBACK to the publisher, PUBLISH to the subscriber, its PUBACK; with and without a log.
void qos1_one_to_one(benchmark::State& state) {
    Bench bench{state.range(0) != 0};
    bench.connects(0);
    bench.connects(1);
    bench.registers(0, "pose");
    bench.subscribes(1, "pose", Qos::at_least_once);
    std::uint16_t msg_id = 0;
    for ([[maybe_unused]] auto _ : state) {
        if (++msg_id == 0) msg_id = 1;
        bench.hears(0, publish(Qos::at_least_once, msg_id));
        bench.hears(1, encoded(Puback{TopicId{1}, MsgId{msg_id}, ReturnCode::accepted}));
        bench.passes(1us);
    }
    state.SetItemsProcessed(state.iterations());
}
BENCHMARK(qos1_one_to_one)->Arg(0)->Arg(1);

void qos2_one_to_one(benchmark::State& state) {
    Bench bench{state.range(0) != 0};
    bench.connects(0);
    bench.connects(1);
    bench.registers(0, "pose");
    bench.subscribes(1, "pose", Qos::exactly_once);
    std::uint16_t msg_id = 0;
    for ([[maybe_unused]] auto _ : state) {
        if (++msg_id == 0) msg_id = 1;
        bench.hears(0, publish(Qos::exactly_once, msg_id));
        bench.hears(0, encoded(Pubrel{MsgId{msg_id}}));
        bench.hears(1, encoded(Pubrec{MsgId{msg_id}}));
        bench.hears(1, encoded(Pubcomp{MsgId{msg_id}}));
        bench.passes(1us);
    }
    state.SetItemsProcessed(state.iterations());
}
BENCHMARK(qos2_one_to_one)->Arg(0)->Arg(1);

void topic_match(benchmark::State& state) {
    TopicTree<std::uint32_t, std::uint32_t> tree;
    const auto filters = static_cast<std::uint32_t>(state.range(0));
    for (std::uint32_t i = 0; i < filters; ++i) {
        tree.put("robot/" + std::to_string(i) + "/pose", i, 0);
        if (i % 10 == 0) tree.put("robot/" + std::to_string(i) + "/+", i, 0);
    }
    tree.put("robot/+/pose", filters, 0);
    std::vector<std::string> names;
    for (std::uint32_t i = 0; i < 64; ++i) {
        names.push_back("robot/" + std::to_string(i * 7919 % filters) + "/pose");
    }
    std::size_t at = 0;
    std::uint64_t found = 0;
    for ([[maybe_unused]] auto _ : state) {
        tree.match(names[at++ % names.size()],
                   [&](std::uint32_t who, std::uint32_t) { found += who; });
    }
    benchmark::DoNotOptimize(found);
    state.SetItemsProcessed(state.iterations());
}
BENCHMARK(topic_match)->Arg(10)->Arg(10'000);

void decode_publish(benchmark::State& state) {
    const Octets datagram = publish(Qos::at_least_once, 7);
    for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(wire::decode(datagram));
    state.SetItemsProcessed(state.iterations());
}
BENCHMARK(decode_publish);

void encode_publish(benchmark::State& state) {
    const Octets payload(32, 'x');
    Octets room(64);
    const Publish message{false,      Qos::at_least_once, false,  TopicIdType::normal,
                          TopicId{1}, MsgId{7},           payload};
    for ([[maybe_unused]] auto _ : state) {
        benchmark::DoNotOptimize(wire::encode(message, room));
        benchmark::ClobberMemory();
    }
    state.SetItemsProcessed(state.iterations());
}
BENCHMARK(encode_publish);

void decode_puback(benchmark::State& state) {
    const Octets datagram = encoded(Puback{TopicId{1}, MsgId{7}, ReturnCode::accepted});
    for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(wire::decode(datagram));
    state.SetItemsProcessed(state.iterations());
}
BENCHMARK(decode_puback);

void pingreq_of_20000_sessions(benchmark::State& state) {
    Bench bench;
    for (std::uint32_t i = 0; i < 20'000; ++i) bench.connects(i);
    const Octets ping = encoded(Pingreq{});
    std::uint32_t at = 0;
    for ([[maybe_unused]] auto _ : state) bench.hears(at++ % 20'000, ping);
    state.SetItemsProcessed(state.iterations());
}
BENCHMARK(pingreq_of_20000_sessions);

/// Heap of a session that has connected, registered a topic and subscribed to two.
void quiet_session_memory(benchmark::State& state) {
    constexpr std::uint32_t sessions = 20'000;
    for ([[maybe_unused]] auto _ : state) {
        const auto before = mallinfo2().uordblks;
        Bench bench;
        for (std::uint32_t i = 0; i < sessions; ++i) {
            bench.connects(i);
            bench.registers(i, "robot/" + std::to_string(i) + "/pose");
            bench.subscribes(i, "robot/" + std::to_string(i) + "/command", Qos::at_least_once);
            bench.subscribes(i, "common", Qos::at_least_once);
        }
        state.counters["octets_a_session"] =
            static_cast<double>(mallinfo2().uordblks - before) / sessions;
    }
}
BENCHMARK(quiet_session_memory)->Unit(benchmark::kMillisecond)->Iterations(1);

}  // namespace

BENCHMARK_MAIN();
