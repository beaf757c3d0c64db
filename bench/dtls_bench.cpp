// What DTLS costs at a broker, without sockets: records sealed and opened, and handshakes with a
// pre-shared key, the broker's share of them alone.
//
//     cmake --preset release && cmake --build --preset release --target romano_dtls_bench
//     build/release/bin/romano_dtls_bench

#include <benchmark/benchmark.h>
#include <time.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <utility>
#include <vector>

#include "broker/dtls/openssl/listener.h"
#include "romano/dtls/client_end.h"

namespace {

using namespace romano;
using Octets = std::vector<std::uint8_t>;

constexpr const char* suite_names[] = {"PSK-AES128-CCM8", "PSK-AES128-GCM-SHA256"};

/// A broker's end and the client's records.
class Pair {
public:
    explicit Pair(dtls::Suite suite)
        : keys_{suite, {{1}, {2}}, {{3}, {4}}}, association_(dtls::AssociationId{1}, {}, keys_) {
        reserve_.on_stored(dtls::most_count);
    }
    std::size_t seal(Bytes message, MutableBytes out) {
        const auto size = association_.seal(cipher_, {1, reserve_},
                                            dtls::ContentType::application_data, message, out);
        return size ? *size : 0;
    }
    std::size_t seal_as_client(Bytes message, MutableBytes out) {
        return cipher_.seal(keys_.suite, keys_.client, dtls::ContentType::application_data,
                            number_++, message, out);
    }
    bool open(Bytes datagram, MutableBytes out) {
        return association_.open(cipher_, *dtls::first_record(datagram), out).has_value();
    }

private:
    dtls::RecordKeys keys_;
    dtls::Association association_;
    dtls::RecordCipher cipher_;
    protection::Reserve reserve_{0};
    std::uint64_t number_ = 1;
};

void sealed(benchmark::State& state) {
    Pair pair{dtls::Suite{static_cast<std::uint8_t>(state.range(0))}};
    const Octets message(static_cast<std::size_t>(state.range(1)), 'x');
    Octets datagram(message.size() + dtls::most_overhead);
    for ([[maybe_unused]] auto _ : state) {
        benchmark::DoNotOptimize(pair.seal(message, datagram));
        benchmark::ClobberMemory();
    }
    state.SetItemsProcessed(state.iterations());
    state.SetLabel(suite_names[state.range(0)]);
}
BENCHMARK(sealed)->ArgsProduct({{0, 1}, {39, 512}})->ArgNames({"suite", "octets"});

/// Each record is new: an old one would be refused unopened.
void sealed_and_opened(benchmark::State& state) {
    Pair pair{dtls::Suite{static_cast<std::uint8_t>(state.range(0))}};
    const Octets message(static_cast<std::size_t>(state.range(1)), 'x');
    Octets datagram(message.size() + dtls::most_overhead);
    Octets out(message.size());
    for ([[maybe_unused]] auto _ : state) {
        const std::size_t size = pair.seal_as_client(message, datagram);
        if (!pair.open(Bytes{datagram}.first(size), out)) state.SkipWithError("not opened");
    }
    state.SetItemsProcessed(state.iterations());
    state.SetLabel(suite_names[state.range(0)]);
}
BENCHMARK(sealed_and_opened)->ArgsProduct({{0, 1}, {39, 512}})->ArgNames({"suite", "octets"});

void forged_record_refused(benchmark::State& state) {
    Pair pair{dtls::Suite::aes_128_ccm_8};
    Octets datagram(39 + dtls::most_overhead);
    const Octets message(39, 'x');
    datagram.resize(pair.seal_as_client(message, datagram));
    datagram.back() ^= 1U;
    Octets out(message.size());
    for ([[maybe_unused]] auto _ : state) {
        if (pair.open(datagram, out)) state.SkipWithError("a forged record was opened");
    }
    state.SetItemsProcessed(state.iterations());
}
BENCHMARK(forged_record_refused);

/// Of this thread on a processor: on a busy machine others have the rest.
std::chrono::nanoseconds processor_time() {
    timespec time{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return std::chrono::seconds{time.tv_sec} + std::chrono::nanoseconds{time.tv_nsec};
}

/// A broker that knows one client, and what it answers.
struct Broker {
    Broker() {
        reserve.on_stored(dtls::most_count);
        const std::array<broker::ProtectedClient, 1> all{broker::ProtectedClient{"a", key}};
        listener.set_clients(all);
        via.packets = Endpoint::Packets::dtls;
    }
    void take(Bytes datagram) {
        actions.clear();
        listener.take(Instant{}, {via, from}, datagram, actions, [](const dtls::Message&) {});
    }

    const protection::RobotKey key{{0xA}};
    protection::Reserve reserve{0};
    dtls::Listener listener{{1, reserve}, {0x5E}};
    Endpoint from{.address = {127, 0, 0, 1}, .port = 8883, .family = Endpoint::Family::ipv4};
    Endpoint via = from;
    broker::Actions actions;
};

/// Of a stranger: the answer is its cookie.
void first_client_hello(benchmark::State& state) {
    Broker broker;
    Octets hello;
    dtls::ClientEnd client("a", protection::pre_shared_key(broker.key),
                           [&](Bytes datagram) { hello.assign(datagram.begin(), datagram.end()); });
    client.connect();
    for ([[maybe_unused]] auto _ : state) {
        ++broker.from.port;
        broker.take(hello);
        if (broker.actions.list().size() != 1) state.SkipWithError("no answer");
    }
    state.SetItemsProcessed(state.iterations());
}
BENCHMARK(first_client_hello);

/// The broker's share of a handshake, cookie included: the client's time is not counted.
void handshake(benchmark::State& state) {
    Broker broker;
    std::chrono::nanoseconds spent{};
    for ([[maybe_unused]] auto _ : state) {
        ++broker.from.port;
        std::vector<Octets> outbox;
        dtls::ClientEnd client("a", protection::pre_shared_key(broker.key), [&](Bytes datagram) {
            outbox.emplace_back(datagram.begin(), datagram.end());
        });
        client.connect();
        spent = {};
        const auto exchange = [&] {
            while (!outbox.empty()) {
                for (const Octets& datagram : std::exchange(outbox, {})) {
                    const auto began = processor_time();
                    broker.take(datagram);
                    spent += processor_time() - began;
                    for (const auto& action : broker.actions.list()) {
                        const auto& send = std::get<broker::Send>(action);
                        (void)client.open(broker.actions.octets(send));
                    }
                }
            }
        };
        exchange();
        const std::array<std::uint8_t, 2> ping{2, 22};
        if (!client.seal(ping)) state.SkipWithError("no handshake");
        exchange();
        state.SetIterationTime(std::chrono::duration<double>(spent).count());
    }
    state.SetItemsProcessed(state.iterations());
}
BENCHMARK(handshake)->UseManualTime();

}  // namespace

BENCHMARK_MAIN();
