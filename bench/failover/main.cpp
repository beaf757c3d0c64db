// romano_failover_bench: how long is a robot without its broker?

#include <CLI/CLI.hpp>
#include <boost/asio/io_context.hpp>
#include <csignal>
#include <cstdio>
#include <exception>
#include <stdexcept>
#include <string>

#include "bench/failover/bench.h"
#include "bench/failover/results.h"
#include "bench/failover/trade.h"
#include "broker/net/clock.h"
#include "romano/cli/loopback_network.h"

namespace {

using namespace romano::bench;

constexpr const char* examples = R"(Examples:
  romano_failover_bench --trials 1000 --fault crash
  romano_failover_bench --trials 1000 --fault silence --victim leader --brokers 5
  romano_failover_bench --trials 200 --listener dtls         (clients with keys: protected, dtls)
  romano_failover_bench --trials 0 --watch-s 150             (full load, no fault: who is taken for dead?)
  romano_failover_bench --trials 0 --watch-s 40 --away-s 10  (does a victim that comes back disturb anybody?)
  romano_failover_bench --timeouts-ms 20 30 50 80 120 --trials 30 --watch-s 60      (the trade, as a plot)
  romano_failover_bench --trials 100 -- --detection-timeout-ms 100     (options of the brokers)
The same command goes on where it was interrupted; --fresh begins anew.
Writes trials.csv, summary.json, failover.svg and the brokers' traces into --output.
Exit code: 0; 1 when a client had to connect, register or subscribe again or to make a handshake, or
heard nothing; 2 when the bench could not run.)";

volatile std::sig_atomic_t interrupted = 0;

void read(CLI::App& app, Options& options) {
    app.add_option("--trials", options.trials, "Trials in all, with those of before")
        ->capture_default_str();
    app.add_option("--brokers", options.brokers, "Brokers, at least 2")
        ->check(CLI::Range(2, 32))
        ->capture_default_str();
    app.add_option_function<std::string>(
           "--fault",
           [&options](const std::string& name) {
               options.fault = name == "crash" ? Fault::crash : Fault::silence;
           },
           "crash: kill -9; silence: SIGSTOP")
        ->check(CLI::IsMember({"crash", "silence"}).description(""))
        ->type_name("crash|silence")
        ->default_str("crash");
    app.add_option_function<std::string>(
           "--victim",
           [&options](const std::string& name) {
               options.victim = name == "leader" ? Victim::leader : Victim::other;
           },
           "Whom it befalls")
        ->check(CLI::IsMember({"leader", "other"}).description(""))
        ->type_name("leader|other")
        ->default_str("other");
    app.add_option_function<std::string>(
           "--listener",
           [&options](const std::string& name) {
               options.packets = name == "plain"       ? romano::Endpoint::Packets::plain
                                 : name == "protected" ? romano::Endpoint::Packets::sealed
                                                       : romano::Endpoint::Packets::dtls;
           },
           "What brokers listen for and clients speak")
        ->check(CLI::IsMember({"plain", "protected", "dtls"}).description(""))
        ->type_name("plain|protected|dtls")
        ->default_str("plain");
    app.add_option("--qos", options.qos, "Of publishes and subscriptions")
        ->check(CLI::Range(0, 2))
        ->capture_default_str();
    app.add_option("--seed", options.seed, "Who is struck, and when")->capture_default_str();
    app.add_option("--domain", options.domain, "DDS domain of the brokers")
        ->check(CLI::Range(0, 230))
        ->capture_default_str();
    app.add_option("--network", options.network, "Loopback network of the brokers")
        ->check(romano::loopback_network())
        ->capture_default_str();
    app.add_option("--port", options.port, "Their UDP port")->capture_default_str();
    app.add_option("--output", options.output,
                   "Results folder (default: results/failover-<fault>-<victim>-<brokers>, "
                   "and behind it the listener unless it is plain)");
    app.add_option("--at-most-s", options.at_most_s, "Stop after so many seconds, to be resumed");
    app.add_option("--watch-s", options.watch_s,
                   "Then so many seconds of full load; counts false failovers");
    app.add_option(
        "--away-s", options.away_s,
        "In the middle of that the victim is away for so many seconds (default: no fault)");
    app.add_option("--timeouts-ms", options.timeouts_ms,
                   "Silent brokers, and the watch, at each of these detection timeouts");
    app.add_flag("--fresh", options.fresh, "Forget the trials of before");
    app.add_option("--broker", options.broker_program,
                   "The broker's program (default: romano-broker beside this program)");
    app.add_option("BROKER-OPTION", options.broker_arguments, "After --: options of the brokers");
    app.footer(examples);
}

int run(Options options) {
    if (options.away_s != 0 && options.away_s + 2 > options.watch_s) {
        throw std::invalid_argument("--away-s " + std::to_string(options.away_s) +
                                    ": must be less than --watch-s (" +
                                    std::to_string(options.watch_s) + ") by 2 at least");
    }
    if (options.broker_program.empty()) {
        options.broker_program =
            std::filesystem::read_symlink("/proc/self/exe").parent_path() / "romano-broker";
    }
    if (options.output.empty()) {
        options.output = "results/failover-" + std::string{name_of(options.fault)} + "-" +
                         name_of(options.victim) + "-" + std::to_string(options.brokers);
        if (options.packets != romano::Endpoint::Packets::plain) {
            options.output += std::string{"-"} + name_of(options.packets);
        }
    }
    const auto begun = romano::net::now();
    const auto is_over = [&] {
        return interrupted != 0 ||
               (options.at_most_s != 0 &&
                romano::net::now() - begun > std::chrono::seconds{options.at_most_s});
    };
    if (!options.timeouts_ms.empty()) return run_trade(options, is_over) ? 0 : 130;
    Results results(options);
    if (results.trials().size() < options.trials || options.watch_s > 0) {
        // Another seed for each part of an interrupted run.
        options.seed += results.trials().size();
        boost::asio::io_context io{1};
        Bench bench(io, options, results.traces());
        bench.start();
        while (results.trials().size() < options.trials && !is_over()) {
            results.add(bench.run(static_cast<std::uint32_t>(results.trials().size()) + 1));
        }
        if (options.watch_s > 0 && !is_over())
            results.add(bench.watch(std::chrono::seconds{options.watch_s}, is_over));
    }
    results.conclude();
    for (const Trial& trial : results.trials()) {
        const auto noticed = trial.connects + trial.registers + trial.subscribes + trial.handshakes;
        if (!trial.total_ms || noticed > 0) return 1;
    }
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app{
        "Strikes one broker of a cluster again and again, and measures the time until its "
        "client hears its new home: real processes, DDS on loopback.",
        "romano_failover_bench"};
    Options options;
    read(app, options);
    std::signal(SIGINT, [](int) { interrupted = 1; });
    std::signal(SIGTERM, [](int) { interrupted = 1; });
    try {
        app.parse(argc, argv);
        return run(std::move(options));
    } catch (const CLI::Success& asked) {
        return app.exit(asked);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "romano_failover_bench: %s\n", error.what());
        return 2;
    }
}
