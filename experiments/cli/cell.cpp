#include "experiments/cli/cell.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/system/system_error.hpp>
#include <chrono>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "broker/net/endpoint_text.h"
#include "experiments/air/radio_bridge.h"
#include "experiments/cli/interrupt.h"
#include "romano/cli/real_number.h"

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;

constexpr const char* cell_examples = R"(Examples:
  romano cell --listen 127.0.1.1:1883 --broker 127.0.0.1:1883
  romano-robot --broker 127.0.1.1:1883 --count 5 --heartbeat 1 --quiet      (five robots on the air)
  romano load -h 127.0.0.1 --also 127.0.1.1 --rate 100                      (from the wire to a robot)
  romano cell --listen 127.0.1.1:1883 --broker 127.0.0.1:1883 \\
              --listen 127.0.1.2:1883 --broker 127.0.0.2:1883 --channels 1  (two that hear each other)
  romano cell --listen 127.0.1.1:1883 --broker 127.0.0.1:1883 --cell-group 239.18.83.1:1884
      (one datagram for many: the broker and the robots have that --cell-group as well)
Robots talk to --listen as to a broker: UART, IEEE 802.15.4 with 6LoWPAN on ns-3, border router and its
UART lie between (overlay/radio), in real time. Ctrl-C ends it and prints what the channel did. Whoever
measures should look at its exit code.
Exit code: 0; 1 when more than one datagram in a hundred was handed over later than --most-lag-ms after
its time, so that what was measured is not the channel's; 2 when a setting is not possible.
)";

struct CellOptions {
    RadioBridgeOptions bridge;
    std::vector<std::string> listen;
    std::vector<std::string> brokers;
    std::string cell_group;
    std::string router_baud = "115200";
    std::string robot_baud = "115200";
    double most_lag_ms = 5;
    double duration_s = 0;  // 0: until it is interrupted
    bool json = false;
};

Endpoint address_in(const char* option, const std::string& text) {
    const auto endpoint = net::parse_endpoint(text);
    if (!endpoint || endpoint->port == 0) {
        throw std::invalid_argument(std::string{option} + " `" + text +
                                    "`: must be an IP address and a port, such as 127.0.1.1:1883");
    }
    return *endpoint;
}

std::optional<std::uint32_t> baud_in(const char* option, const std::string& text) {
    if (text == "none") return std::nullopt;
    std::uint32_t baud = 0;
    if (!CLI::detail::lexical_cast(text, baud)) {
        throw std::invalid_argument(std::string{option} + " `" + text +
                                    "`: must be a baud, or none");
    }
    return baud;
}

RadioBridgeOptions bridge_options(const CellOptions& options) {
    RadioBridgeOptions bridge = options.bridge;
    if (options.listen.size() != options.brokers.size()) {
        throw std::invalid_argument(
            "--listen is given " + std::to_string(options.listen.size()) + " times and --broker " +
            std::to_string(options.brokers.size()) + " times: each cell has one of both");
    }
    for (std::size_t i = 0; i < options.listen.size(); ++i) {
        bridge.cells.push_back({address_in("--listen", options.listen[i]),
                                address_in("--broker", options.brokers[i])});
    }
    if (!options.cell_group.empty()) {
        bridge.group = address_in("--cell-group", options.cell_group);
    }
    bridge.router_baud = baud_in("--router-baud", options.router_baud);
    bridge.robot_baud = baud_in("--robot-baud", options.robot_baud);
    bridge.most_lag = std::chrono::duration_cast<std::chrono::microseconds>(
        std::chrono::duration<double, std::milli>{options.most_lag_ms});
    if (const auto problem = problem_with(bridge)) throw std::invalid_argument(*problem);
    return bridge;
}

double ms(Duration duration) {
    return std::chrono::duration<double, std::milli>(duration).count();
}

std::string json_of(const RadioBridgeFigures& figures) {
    const nlohmann::ordered_json json{{"datagrams_to_brokers", figures.to_brokers},
                                      {"datagrams_to_robots", figures.to_robots},
                                      {"datagrams_to_cells", figures.to_cells},
                                      {"lost_in_queues", figures.lost_in_queues},
                                      {"frames_given_up", figures.given_up_on_air},
                                      {"busiest_cell_air_share", figures.air_share},
                                      {"too_large", figures.too_large},
                                      {"without_place", figures.without_place},
                                      {"lag_p50_ms", ms(figures.lag.at(0.5))},
                                      {"lag_p99_ms", ms(figures.lag.at(0.99))},
                                      {"lag_max_ms", ms(figures.lag.max())},
                                      {"handed_over_late", figures.late}};
    return json.dump(2) + "\n";
}

std::string text_of(const RadioBridgeFigures& figures) {
    std::string text = std::to_string(figures.to_brokers) + " datagrams to brokers, " +
                       std::to_string(figures.to_robots) + " to robots; " +
                       std::to_string(figures.lost_in_queues) + " lost in full queues, " +
                       std::to_string(figures.given_up_on_air) +
                       " frames given up on the air, which was taken " +
                       std::to_string(static_cast<int>(100 * figures.air_share + 0.5)) +
                       " % of the time in the busiest cell\n";
    if (figures.to_cells > 0) {
        text += std::to_string(figures.to_cells) +
                " datagrams went once to a whole cell, to the robots that listen there\n";
    }
    if (figures.too_large > 0) {
        text += std::to_string(figures.too_large) +
                " datagrams were larger than the 1,000 octets that 6LoWPAN carries here\n";
    }
    if (figures.without_place > 0) {
        text += std::to_string(figures.without_place) +
                " datagrams came from robots for which no place was free (--robots)\n";
    }
    return text;
}

int run(const CellOptions& options) {
    const RadioBridgeOptions chosen = bridge_options(options);
    boost::asio::io_context io{1};
    std::unique_ptr<RadioBridge> bridge;
    try {
        bridge = std::make_unique<RadioBridge>(
            io, chosen, [] { std::fputs("romano: the cell lags behind its channel\n", stderr); });
    } catch (const boost::system::system_error& error) {
        const std::string options_of_sockets =
            chosen.group ? "--listen, --broker or --cell-group: " : "--listen or --broker: ";
        throw std::invalid_argument(options_of_sockets + error.code().message());
    }
    const Interrupt interrupt{io};
    for (const std::string& listen : options.listen) {
        std::fprintf(stderr, "a cell is at %s\n", listen.c_str());
    }
    const auto began = std::chrono::steady_clock::now();
    const std::chrono::duration<double> lasts{options.duration_s};
    while (!interrupt.has_come()) {
        if (options.duration_s > 0 && std::chrono::steady_clock::now() - began >= lasts) break;
        io.run_one_for(100ms);
    }
    const RadioBridgeFigures figures = bridge->figures();
    if (figures.has_lagged()) {
        std::fprintf(
            stderr,
            "romano: %llu of %llu datagrams were handed over more than %g ms late, %.1f ms "
            "at most: what was measured is not the channel's; give the machine less to do, "
            "or allow more by --most-lag-ms\n",
            static_cast<unsigned long long>(figures.late),
            static_cast<unsigned long long>(figures.lag.count()), options.most_lag_ms,
            ms(figures.lag.max()));
        return 1;
    }
    const std::string report = options.json ? json_of(figures) : text_of(figures);
    std::fputs(report.c_str(), stdout);
    return 0;
}

}  // namespace

void add_cell(CLI::App& program, int& exit_code) {
    auto options = std::make_shared<CellOptions>();
    RadioBridgeOptions& bridge = options->bridge;
    CLI::App& command = *program.add_subcommand(
        "cell", "Modelled radio cells between real robots and real brokers, in real time");
    command.set_help_flag("--help", "Show this and examples, and exit");
    command
        .add_option("--listen", options->listen,
                    "Where robots find the cell (repeatable, each with its --broker)")
        ->required()
        ->type_name("ADDR:PORT");
    command.add_option("--broker", options->brokers, "The broker behind the cell (repeatable)")
        ->required()
        ->type_name("ADDR:PORT");
    command
        .add_option("--cell-group", options->cell_group,
                    "The brokers' --cell-group: what they send there goes once on the air")
        ->type_name("ADDR:PORT");
    command.add_option("--robots", bridge.robots, "Places in each cell")
        ->check(CLI::Range(1, 200))
        ->capture_default_str();
    command.add_option("--channels", bridge.channels, "Channels that the cells take in turn")
        ->check(CLI::Range(1, 16))
        ->capture_default_str();
    command.add_option("--router-baud", options->router_baud, "Of the border routers' UARTs")
        ->type_name("BAUD|none")
        ->capture_default_str();
    command.add_option("--robot-baud", options->robot_baud, "Of the robots' UARTs")
        ->type_name("BAUD|none")
        ->capture_default_str();
    command.add_option("--router-distance-m", bridge.router_distance_m, "From router to router")
        ->check(real_number(5, 10'000))
        ->capture_default_str();
    command.add_option("--seed", bridge.seed, "Of the channel")->capture_default_str();
    command
        .add_option("--most-lag-ms", options->most_lag_ms,
                    "So late a datagram may be handed over after its time")
        ->check(real_number(0.1, 1'000))
        ->capture_default_str();
    command.add_option("--duration", options->duration_s, "End after so many seconds")
        ->check(real_number(0.1, 1e6));
    command.add_flag("--json", options->json, "Print the figures as JSON");
    command.footer(cell_examples);
    command.callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace romano::experiments
