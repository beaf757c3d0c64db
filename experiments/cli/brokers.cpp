#include "experiments/cli/brokers.h"

#include <algorithm>
#include <array>
#include <boost/asio/io_context.hpp>
#include <chrono>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "broker/net/clock.h"
#include "experiments/cli/broker_options.h"
#include "experiments/cli/denial.h"
#include "experiments/report/summary_table.h"
#include "experiments/robots/socket_client.h"
#include "experiments/watch/broker_watch.h"

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;

constexpr const char* brokers_examples = R"(Examples:
  romano brokers
  romano brokers -h 127.0.0.2 -p 1884
  romano brokers --json | jq '.[] | select(.leader)'
)";

/// The words on brokers come one by one; they are all there when the view's members are.
bool is_complete(const BrokerWatch& watch) {
    if (watch.brokers().empty()) return false;
    for (const auto& [name, seen] : watch.brokers()) {
        for (const std::string& member : seen.status.view_members) {
            if (!watch.brokers().contains(member)) return false;
        }
    }
    return true;
}

std::string joined(const std::vector<std::string>& words) {
    std::string text;
    for (const std::string& word : words) text += (text.empty() ? "" : " ") + word;
    return text;
}

/// The longest that the broker did one thing and nothing else, of late.
std::string turn_text(std::uint64_t microseconds) {
    std::array<char, 32> text{};
    (void)std::snprintf(text.data(), text.size(), "%.2f ms",
                        static_cast<double>(microseconds) / 1e3);
    return text.data();
}

std::string percent_text(const std::optional<std::uint64_t>& percent) {
    return percent ? std::to_string(*percent) + " %" : "";
}

/// What must be the same at all brokers, and is not.
void print_disagreements(const BrokerWatch& watch) {
    for (const auto& [name, seen] : watch.brokers()) {
        for (const auto& [setting, values] : seen.status.disagrees) {
            std::string text;
            for (const auto& [broker, value] : values) {
                text += (text.empty() ? "" : ", ") + broker + " has '" + value + "'";
            }
            std::printf("\nthe brokers disagree about %s: %s\n", setting.c_str(), text.c_str());
        }
    }
}

/// Whose machine would not let it go on for others; its own trace says what to do.
void print_inability(const BrokerWatch& watch) {
    for (const auto& [name, seen] : watch.brokers()) {
        if (!seen.status.alive || seen.status.cannot_take == 0) continue;
        std::printf("\n%s cannot take over %llu of the other brokers' addresses (see its log)\n",
                    name.c_str(), static_cast<unsigned long long>(seen.status.cannot_take));
    }
}

/// Whose packets do not reach whom: broken or one-way links.
void print_deafness(const BrokerWatch& watch) {
    for (const auto& [name, seen] : watch.brokers()) {
        if (!seen.status.alive || seen.status.does_not_hear.empty()) continue;
        std::printf("\n%s does not hear %s\n", name.c_str(),
                    joined(seen.status.does_not_hear).c_str());
    }
}

void print_table(const BrokerWatch& watch) {
    SummaryTable table{.head = {"broker", "state", "role", "rank", "condition", "sessions",
                                "connected", "CPU", "longest turn", "addresses"},
                       .units = {},
                       .rows = {}};
    const BrokerStatus* newest = nullptr;
    for (const auto& [name, seen] : watch.brokers()) {
        const BrokerStatus& status = seen.status;
        table.rows.push_back(
            {status.name, status.alive ? "alive" : "dead",
             status.alive && status.leader ? "leader" : "", std::to_string(status.rank),
             status.condition ? std::to_string(*status.condition) : "",
             std::to_string(status.sessions), std::to_string(status.connected),
             status.alive ? percent_text(status.cpu_percent) : "",
             status.alive ? turn_text(status.longest_turn_us) : "", joined(status.addresses)});
        if (status.alive && (newest == nullptr || status.view_term > newest->view_term)) {
            newest = &status;
        }
    }
    std::fputs(to_text(table).c_str(), stdout);
    if (newest != nullptr && !newest->view_members.empty()) {
        std::printf("\nview of term %llu, led by %s: %s\n",
                    static_cast<unsigned long long>(newest->view_term),
                    newest->view_leader.empty() ? "nobody" : newest->view_leader.c_str(),
                    joined(newest->view_members).c_str());
    }
    print_deafness(watch);
    print_inability(watch);
    print_disagreements(watch);
}

void print_json(const BrokerWatch& watch) {
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const auto& [name, seen] : watch.brokers()) {
        list.push_back(nlohmann::ordered_json::parse(seen.text));
    }
    std::puts(list.dump(2).c_str());
}

}  // namespace

void see_brokers(const BrokerOptions& options,
                 const std::function<void(const BrokerWatch&)>& show) {
    boost::asio::io_context io{1};
    Sockets sockets{io, options.packets()};
    BrokerWatch watch{sockets,
                      resolve_broker(io, options.host, options.port),
                      options.id_or("romano-brokers"),
                      options.timing(),
                      {}};
    while (!watch.is_subscribed()) {
        io.run_one_for(50ms);
        if (watch.has_failed()) {
            throw CommandError(why_not(options, watch.denial(), watch.client().was_refused()));
        }
    }
    const Instant patience = net::now() + 2s;
    while (!is_complete(watch) && net::now() < patience) io.run_one_for(20ms);
    // Brokers that are no member of the view any more are told of too, in the same burst.
    const Instant rest = net::now() + 50ms;
    while (net::now() < rest) io.run_one_for(10ms);
    watch.leave();
    if (watch.brokers().empty()) {
        throw CommandError("the broker at " + options.where() + " says nothing on " +
                           std::string{brokers_filter} + ": it is no romano-broker");
    }
    show(watch);
}

void add_brokers(CLI::App& program, int& exit_code) {
    auto options = std::make_shared<BrokerOptions>();
    auto as_json = std::make_shared<bool>(false);
    CLI::App& command = *program.add_subcommand(
        "brokers", "Show the cluster as one of its brokers sees it: who lives, leads, serves");
    options->add_to(command);
    options->add_key_to(command);
    command.add_flag("--json", *as_json, "Print what the broker says, as a JSON array");
    command.footer(brokers_examples);
    command.callback([options, as_json, &exit_code] {
        see_brokers(*options, *as_json ? print_json : print_table);
        exit_code = 0;
    });
}

}  // namespace romano::experiments
