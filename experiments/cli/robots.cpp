#include "experiments/cli/robots.h"

#include <chrono>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "broker/net/clock.h"
#include "experiments/cli/broker_options.h"
#include "experiments/cli/denial.h"
#include "experiments/cli/interrupt.h"
#include "experiments/operator/message_text.h"
#include "experiments/operator/node_watch.h"
#include "experiments/report/summary_table.h"
#include "romano/server/server.h"

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;

constexpr const char* robots_examples = R"(Examples:
  romano robots
  romano robots --follow                      (heartbeats, arrivals and departures as they come)
  romano robots -h 127.0.0.2 --json | jq -r '.[] | select(.state == "silent").robot'

State: connected; silent (connected, but its heartbeats are missing: messages to it wait);
away (not connected, its session is kept, and so are messages to it). Brokers tell of a robot's
heartbeats every ten seconds: "within 9 s". --follow hears each.
)";

std::uint64_t unix_ms() {
    return static_cast<std::uint64_t>(
        std::chrono::duration_cast<std::chrono::milliseconds>(net::unix_time()).count());
}

/// Of a robot whose heartbeats come the entry is up to ten seconds old; of others it is the last.
std::string age(const server::NodeEntry& node, std::uint64_t now_ms) {
    if (node.heartbeat_unix_ms == 0) return "none";
    const std::uint64_t ms = now_ms > node.heartbeat_unix_ms ? now_ms - node.heartbeat_unix_ms : 0;
    return node.state == server::NodeState::connected
               ? "within " + std::to_string(ms / 1000 + 1) + " s"
               : std::to_string(ms / 1000) + " s ago";
}

void print_table(const NodeWatch& watch) {
    SummaryTable table{
        .head = {"robot", "state", "home", "heartbeat", "form", "client"}, .units = {}, .rows = {}};
    const std::uint64_t now = unix_ms();
    for (const auto& [id, node] : watch.nodes()) {
        table.rows.push_back({std::string{id.text()}, std::string{server::name_of(node.state)},
                              node.home, age(node, now), std::string{server::name_of(node.form)},
                              node.client});
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

/// What a message tells of a robot: a line, or nothing new.
std::string news_of(const NodeWatch& watch, std::string_view topic, Bytes data) {
    if (topic == server::common_topic) {
        const auto message = romano_message(topic, data);
        const auto* beat = message ? std::get_if<message::Heartbeat>(&*message) : nullptr;
        return beat == nullptr ? "" : std::string{beat->sender.text()} + " heartbeat";
    }
    const auto id = message::RomanoId::parse(topic.substr(topic.rfind('/') + 1));
    if (!id) return {};
    const auto known = watch.nodes().find(*id);
    const bool was_known = known != watch.nodes().end();
    if (data.empty()) return was_known ? std::string{id->text()} + " gone" : "";
    const auto entry = server::parse_entry(topic, as_text(data));
    if (!entry) return {};
    const bool is_news =
        !was_known || known->second.state != entry->state || known->second.home != entry->home;
    if (!is_news) return {};
    return std::string{id->text()} + ' ' + std::string{server::name_of(entry->state)} + ", home " +
           entry->home;
}

void follow_robots(const BrokerOptions& options) {
    boost::asio::io_context io{1};
    const Interrupt interrupt{io};
    NodeWatch watch{io, resolve_broker(io, options.host, options.port),
                    options.id_or("romano-robots"), options.timing(), options.packets()};
    watch.set_on_message([&](std::string_view topic, Bytes data) {
        const std::string news = news_of(watch, topic, data);
        if (news.empty()) return;
        std::puts(news.c_str());
        std::fflush(stdout);
    });
    watch.subscribe(std::string{server::entries_filter});
    watch.subscribe(std::string{server::common_topic});
    while (!interrupt.has_come()) {
        io.run_one_for(100ms);
        if (watch.has_failed()) {
            throw CommandError(why_not(options, watch.denial(), watch.was_refused()));
        }
    }
    watch.leave();
}

void show_robots(const BrokerOptions& options, bool as_json) {
    boost::asio::io_context io{1};
    NodeWatch watch{io, resolve_broker(io, options.host, options.port),
                    options.id_or("romano-robots"), options.timing(), options.packets()};
    watch.subscribe(std::string{server::entries_filter});
    const auto turn = [&] {
        io.run_one_for(20ms);
        if (watch.has_failed()) {
            throw CommandError(why_not(options, watch.denial(), watch.was_refused()));
        }
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
    options->add_key_to(command);
    auto follow = std::make_shared<bool>(false);
    CLI::Option* json = command.add_flag("--json", *as_json, "Print a JSON array");
    command
        .add_flag("--follow", *follow,
                  "Print a line for each heartbeat and change, until Ctrl-C, instead of the list")
        ->excludes(json);
    command.footer(robots_examples);
    command.callback([options, as_json, follow, &exit_code] {
        *follow ? follow_robots(*options) : show_robots(*options, *as_json);
        exit_code = 0;
    });
}

}  // namespace romano::experiments
