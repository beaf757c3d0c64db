#include "experiments/cli/robots.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "broker/net/clock.h"
#include "experiments/cli/broker_options.h"
#include "experiments/operator/node_watch.h"
#include "experiments/report/summary_table.h"

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;

constexpr const char* examples = R"(Examples:
  romano robots
  romano robots -h 127.0.0.2 --json | jq -r '.[] | select(.state == "silent").robot'

State: connected; silent (connected, but its heartbeats are missing: messages to it wait);
away (not connected, its session is kept, and so are messages to it).
)";

std::uint64_t unix_ms() {
    return static_cast<std::uint64_t>(
        std::chrono::duration_cast<std::chrono::milliseconds>(net::unix_time()).count());
}

/// "4 s ago"; brokers tell of it every ten seconds.
std::string age(std::uint64_t heartbeat_unix_ms, std::uint64_t now_ms) {
    if (heartbeat_unix_ms == 0) return "none";
    const std::uint64_t ms = now_ms > heartbeat_unix_ms ? now_ms - heartbeat_unix_ms : 0;
    return std::to_string(ms / 1000) + " s ago";
}

void print_table(const NodeWatch& watch) {
    SummaryTable table{
        .head = {"robot", "state", "home", "heartbeat", "form", "client"}, .units = {}, .rows = {}};
    const std::uint64_t now = unix_ms();
    for (const auto& [id, node] : watch.nodes()) {
        table.rows.push_back({std::string{id.text()}, std::string{server::name_of(node.state)},
                              node.home, age(node.heartbeat_unix_ms, now),
                              std::string{server::name_of(node.form)}, node.client});
    }
    std::fputs(to_text(table).c_str(), stdout);
    std::printf("\n%zu robots\n", watch.nodes().size());
}

void print_json(const NodeWatch& watch) {
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const auto& [id, node] : watch.nodes()) {
        nlohmann::ordered_json robot{{"robot", id.text()},
                                     {"state", server::name_of(node.state)},
                                     {"home", node.home},
                                     {"heartbeat_unix_ms", nullptr},
                                     {"form", server::name_of(node.form)},
                                     {"client", node.client}};
        if (node.heartbeat_unix_ms != 0) robot["heartbeat_unix_ms"] = node.heartbeat_unix_ms;
        list.push_back(std::move(robot));
    }
    using nlohmann::json;
    std::puts(list.dump(2, ' ', false, json::error_handler_t::replace).c_str());
}

void show_robots(const BrokerOptions& options, bool as_json) {
    boost::asio::io_context io{1};
    NodeWatch watch{io, resolve_broker(io, options.host, options.port),
                    options.id_or("romano-robots"), options.timing()};
    watch.subscribe(std::string{server::entries_filter});
    const auto turn = [&] {
        io.run_one_for(20ms);
        if (watch.has_failed()) throw CommandError(options.unreachable(watch.was_refused()));
    };
    while (!watch.is_connected() || !watch.is_idle()) turn();
    // The entries come one by one, in one burst.
    std::size_t heard = 0;
    for (Instant rest = net::now() + 200ms; net::now() < rest; turn()) {
        if (watch.heard() != heard) rest = net::now() + 200ms;
        heard = watch.heard();
    }
    watch.leave();
    as_json ? print_json(watch) : print_table(watch);
}

}  // namespace

void add_robots(CLI::App& program, int& exit_code) {
    auto options = std::make_shared<BrokerOptions>();
    auto as_json = std::make_shared<bool>(false);
    CLI::App& command = *program.add_subcommand(
        "robots", "Show the ROMANO robots of the cluster: state, home, last heartbeat");
    options->add_to(command);
    command.add_flag("--json", *as_json, "Print a JSON array");
    command.footer(examples);
    command.callback([options, as_json, &exit_code] {
        show_robots(*options, *as_json);
        exit_code = 0;
    });
}

}  // namespace romano::experiments
