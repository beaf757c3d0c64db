// What a protected packet costs beside the plain message in it, at a broker: two ends, no sockets.
//
//     cmake --preset release && cmake --build --preset release --target romano_protection_bench
//     build/release/bin/romano_protection_bench

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include "romano/mqttsn/codec.h"
#include "romano/protection/broker_end.h"
#include "romano/protection/robot_end.h"

namespace {

using namespace romano;
using Octets = std::vector<std::uint8_t>;

Octets publish_of(std::int64_t data_octets) {
    const Octets data(static_cast<std::size_t>(data_octets), 'x');
    Octets octets(data.size() + 9);
    octets.resize(mqttsn::encode(
        mqttsn::Publish{false, mqttsn::Qos::at_most_once, false, mqttsn::TopicIdType::normal,
                        mqttsn::TopicId{1}, mqttsn::MsgId{0}, data},
        octets));
    return octets;
}

/// The message is copied, as into a datagram, and decoded.
void plain(benchmark::State& state) {
    const Octets message = publish_of(state.range(0));
    Octets datagram(message.size());
    for ([[maybe_unused]] auto _ : state) {
        std::copy(message.begin(), message.end(), datagram.begin());
        benchmark::ClobberMemory();
        benchmark::DoNotOptimize(mqttsn::decode(datagram));
    }
    state.SetItemsProcessed(state.iterations());
}
BENCHMARK(plain)->Arg(32)->Arg(512);

class Pair {
public:
    std::size_t seal(Bytes message, MutableBytes out) {
        if (const auto bound = robot_.reserve().to_store()) robot_.reserve().on_stored(*bound);
        return robot_.seal(message, out);
    }
    Bytes open(MutableBytes packet) { return broker_.open(packet); }

private:
    protection::DirectionKeys keys_{{1}, {2}};
    protection::RobotEnd robot_{keys_, "abcd1234", 0};
    protection::Reserve reserve_{0};
    protection::BrokerEnd broker_{keys_, "abcd1234", {7}, reserve_, std::nullopt};
};

void sealed(benchmark::State& state) {
    Pair pair;
    const Octets message = publish_of(state.range(0));
    Octets datagram(message.size() + protection::most_overhead);
    for ([[maybe_unused]] auto _ : state) {
        benchmark::DoNotOptimize(pair.seal(message, datagram));
        benchmark::ClobberMemory();
    }
    state.SetItemsProcessed(state.iterations());
}
BENCHMARK(sealed)->Arg(32)->Arg(512);

/// Each packet is new: an old one would be refused unopened.
void sealed_opened_and_decoded(benchmark::State& state) {
    Pair pair;
    const Octets message = publish_of(state.range(0));
    Octets datagram(message.size() + protection::most_overhead);
    for ([[maybe_unused]] auto _ : state) {
        const std::size_t size = pair.seal(message, datagram);
        const Bytes opened = pair.open(MutableBytes{datagram}.first(size));
        benchmark::DoNotOptimize(mqttsn::decode(opened));
    }
    state.SetItemsProcessed(state.iterations());
}
BENCHMARK(sealed_opened_and_decoded)->Arg(32)->Arg(512);

/// What a flood of forgeries costs, one each.
void forged(benchmark::State& state) {
    Pair pair;
    const Octets message = publish_of(state.range(0));
    Octets packet(message.size() + protection::most_overhead);
    packet.resize(pair.seal(message, packet));
    packet.back() ^= 1U;
    Octets datagram(packet.size());
    for ([[maybe_unused]] auto _ : state) {
        datagram = packet;
        if (!pair.open(datagram).empty()) state.SkipWithError("a forgery was taken");
    }
    state.SetItemsProcessed(state.iterations());
}
BENCHMARK(forged)->Arg(32)->Arg(512);

}  // namespace

BENCHMARK_MAIN();
