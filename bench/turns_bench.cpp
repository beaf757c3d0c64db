// What it costs to measure each turn of a broker's loop: io.run() beside net::run_in_turns(), which
// runs one handler at a time and reads the clock before and behind it.
//
//     cmake --preset release && cmake --build --preset release --target romano_turns_bench
//     build/release/bin/romano_turns_bench

#include <benchmark/benchmark.h>

#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/post.hpp>
#include <cstdint>

#include "broker/net/clock.h"
#include "broker/net/turn_clock.h"

namespace {

using namespace romano;
using boost::asio::ip::udp;

enum class Loop : std::uint8_t { run, in_turns };

void run(boost::asio::io_context& io, Loop loop) {
    io.restart();
    if (loop == Loop::in_turns) return net::run_in_turns(io);
    io.run();
}

constexpr int handlers = 1000;

/// Handlers that do nothing, one behind the other: the loop alone.
void bench_empty_handlers(benchmark::State& state, Loop loop) {
    boost::asio::io_context io{1};
    auto& turns = net::TurnClock::of(io);
    struct Handler {
        boost::asio::io_context& io;
        net::TurnClock& turns;
        Loop loop;
        int left;
        void operator()() {
            if (loop == Loop::in_turns) turns.begin(net::now());
            if (--left > 0) boost::asio::post(io, *this);
        }
    };
    for (auto _ : state) {
        boost::asio::post(io, Handler{io, turns, loop, handlers});
        run(io, loop);
    }
    state.SetItemsProcessed(state.iterations() * handlers);
}

/// A datagram that wakes the loop, is read and answered, as the least that a broker does in a turn.
void bench_datagrams(benchmark::State& state, Loop loop) {
    boost::asio::io_context io{1};
    auto& turns = net::TurnClock::of(io);
    const udp::endpoint any{boost::asio::ip::make_address("127.0.0.1"), 0};
    udp::socket one{io, any};
    udp::socket other{io, any};
    one.connect(other.local_endpoint());
    other.connect(one.local_endpoint());
    one.non_blocking(true);
    other.non_blocking(true);
    char octets[32] = {};
    int left = 0;
    struct Player {
        udp::socket& socket;
        net::TurnClock& turns;
        Loop loop;
        char* octets;
        int& left;
        void wait() {
            socket.async_wait(udp::socket::wait_read, [this](const auto& error) {
                if (error) return;
                if (loop == Loop::in_turns) turns.begin(net::now());
                socket.receive(boost::asio::buffer(octets, 32));
                --left;
                socket.send(boost::asio::buffer(octets, 32));
                if (left > 1) wait();
            });
        }
    };
    Player first{one, turns, loop, octets, left};
    Player second{other, turns, loop, octets, left};
    for (auto _ : state) {
        left = handlers;
        first.wait();
        second.wait();
        one.send(boost::asio::buffer(octets, 32));
        run(io, loop);
        boost::system::error_code none;  // the last answer
        while (one.receive(boost::asio::buffer(octets, 32), 0, none) > 0) {
        }
        while (other.receive(boost::asio::buffer(octets, 32), 0, none) > 0) {
        }
    }
    state.SetItemsProcessed(state.iterations() * handlers);
}

BENCHMARK_CAPTURE(bench_empty_handlers, run, Loop::run);
BENCHMARK_CAPTURE(bench_empty_handlers, run_in_turns, Loop::in_turns);
BENCHMARK_CAPTURE(bench_datagrams, run, Loop::run);
BENCHMARK_CAPTURE(bench_datagrams, run_in_turns, Loop::in_turns);

}  // namespace

BENCHMARK_MAIN();
