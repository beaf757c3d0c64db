#include "experiments/cli/status.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "experiments/cli/broker_options.h"
#include "experiments/report/summary_table.h"
#include "experiments/watch/metrics_fetch.h"
#include "romano/cli/real_number.h"

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;

constexpr const char* status_examples = R"(Examples:
  romano-broker --metrics 127.0.0.1:9883 &
  romano status
  romano status 127.0.0.2:9883 --every 5
  romano status https://192.168.1.5:9883 --ca authority.pem --name r1 --token metrics.token
  romano status --json | jq '.romano_drops_total'
)";

std::string whole(double number) {
    char text[32];
    std::snprintf(text, sizeof text, "%.0f", number);
    return text;
}

std::string duration_text(double seconds) {
    const auto total = static_cast<long long>(seconds);
    std::ostringstream out;
    if (total >= 86400) out << total / 86400 << " d ";
    if (total >= 3600) out << total / 3600 % 24 << " h ";
    if (total >= 60) out << total / 60 % 60 << " min ";
    out << total % 60 << " s";
    return out.str();
}

std::string label_of(const MetricsPage& page, const char* name, const char* label) {
    const auto& samples = page.all(name);
    if (samples.empty()) return {};
    const auto found = samples.front().labels.find(label);
    return found == samples.front().labels.end() ? std::string{} : found->second;
}

/// "3 queue_full, 1 no_room" or "none".
std::string by_label(const MetricsPage& page, const char* name, const char* label) {
    std::string text;
    for (const MetricSample& sample : page.all(name)) {
        if (sample.value == 0) continue;
        text += (text.empty() ? "" : ", ") + whole(sample.value) + ' ' + sample.labels.at(label);
    }
    return text.empty() ? "none" : text;
}

/// The smallest bound that `share` of the histogram's samples keep.
std::string within(const MetricsPage& page, const std::string& histogram, double share) {
    const double wanted = page.value(histogram + "_count") * share;
    for (const MetricSample& bucket : page.all(histogram + "_bucket")) {
        const std::string& bound = bucket.labels.at("le");
        if (bucket.value < wanted) continue;
        if (bound == "+Inf") break;
        std::ostringstream text;
        text << "< " << std::stod(bound) * 1e3 << " ms";
        return text.str();
    }
    return "longer than measured";
}

class Screen {
public:
    Screen(const MetricsPage& before, const MetricsPage& now, double seconds)
        : before_(before), now_(now), seconds_(seconds) {}

    std::string text() {
        broker();
        line("sessions", by_label(now_, "romano_sessions", "state") + "; " +
                             count("romano_subscriptions") + " subscriptions, " +
                             count("romano_topic_ids") + " topic ids");
        line("queues", count("romano_queued_messages") + " messages wait, at most " +
                           count("romano_longest_queue_messages") + " for one client; " +
                           count("romano_exchanges_in_flight") + " in flight; " +
                           count("romano_retained_messages") + " retained");
        if (now_.has("romano_heap_limit_octets")) {
            const auto mib = [this](const char* name) {
                return whole(now_.value(name) / (1 << 20));
            };
            line("memory", mib("romano_heap_octets") + " of " + mib("romano_heap_limit_octets") +
                               " MiB of heap");
        }
        traffic();
        drops();
        if (now_.has("romano_store_writable")) {
            line("store", now_.value("romano_store_writable") != 0 ? "kept" : "CANNOT BE WRITTEN");
        }
        if (now_.has("romano_cluster_view_members")) cluster();
        return out_.str();
    }

private:
    void line(const char* what, const std::string& text) {
        char head[16];
        std::snprintf(head, sizeof head, "%-10s", what);
        out_ << head << text << '\n';
    }
    [[nodiscard]] std::string count(const char* name) const { return whole(now_.value(name)); }
    [[nodiscard]] std::string rate(const char* name) const {
        const double passed = now_.sum(name) - before_.sum(name);
        return whole(std::max(0.0, passed) / seconds_) + "/s";
    }
    [[nodiscard]] std::string publish_rate(const char* name) const {
        const double passed =
            now_.value(name, "type", "PUBLISH") - before_.value(name, "type", "PUBLISH");
        return whole(std::max(0.0, passed) / seconds_) + "/s";
    }

    void broker() {
        const double up =
            static_cast<double>(std::time(nullptr)) - now_.value("process_start_time_seconds");
        const double cpu =
            now_.value("process_cpu_seconds_total") - before_.value("process_cpu_seconds_total");
        line("broker", label_of(now_, "romano_broker_info", "name") + ", version " +
                           label_of(now_, "romano_broker_info", "version") + ", up " +
                           duration_text(up) + ", " +
                           whole(now_.value("process_resident_memory_bytes") / (1 << 20)) +
                           " MiB, " + whole(100 * cpu / seconds_) + " % of a CPU");
    }

    void traffic() {
        line("messages", rate("romano_messages_received_total") + " in, " +
                             rate("romano_messages_sent_total") + " out; PUBLISH " +
                             publish_rate("romano_messages_received_total") + " in, " +
                             publish_rate("romano_messages_sent_total") + " out; sent again " +
                             rate("romano_retransmissions_total"));
        if (now_.value("romano_datagram_handling_seconds_count") > 0) {
            const std::string name = "romano_datagram_handling_seconds";
            line("handling", "half of the datagrams " + within(now_, name, 0.5) + ", 99 % " +
                                 within(now_, name, 0.99) + ", since the start");
        }
        if (now_.has("romano_longest_turn_seconds")) {
            std::ostringstream text;
            text << now_.value("romano_longest_turn_seconds") * 1e3
                 << " ms did it one thing and nothing else at most, in the last minute";
            line("turn", text.str());
        }
    }

    void drops() {
        line("drops", by_label(now_, "romano_drops_total", "reason"));
        line("malformed", by_label(now_, "romano_malformed_datagrams_total", "reason"));
        line("unsent", by_label(now_, "romano_datagrams_unsent_total", "reason"));
    }

    void cluster() {
        const std::string leader = label_of(now_, "romano_cluster_leader_info", "name");
        line("cluster", "view of term " + count("romano_cluster_view_term") + " with " +
                            count("romano_cluster_view_members") + " brokers, led by " +
                            (leader.empty() ? "nobody" : leader) + "; " +
                            count("romano_cluster_views_total") + " views, " +
                            count("romano_cluster_take_overs_total") + " take-overs so far");
        line("log", "at " + count("romano_cluster_log_position") + ", " +
                        count("romano_cluster_log_unacknowledged_events") + " not acknowledged; " +
                        count("romano_cluster_held_datagrams") + " answers wait for peers");
        SummaryTable peers{
            .head = {"peer", "state", "its log here", "our log there"}, .units = {}, .rows = {}};
        for (const MetricSample& alive : now_.all("romano_cluster_peer_alive")) {
            const std::string& name = alive.labels.at("peer");
            peers.rows.push_back(
                {name, alive.value != 0 ? "alive" : "dead",
                 whole(now_.value("romano_cluster_peer_log_position", "peer", name)),
                 whole(now_.value("romano_cluster_peer_holds_position", "peer", name))});
        }
        if (!peers.rows.empty()) out_ << '\n' << to_text(peers);
    }

    const MetricsPage& before_;
    const MetricsPage& now_;
    double seconds_;
    std::ostringstream out_;
};

std::string page_as_json(const MetricsPage& page, const std::string& text) {
    nlohmann::ordered_json all;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
        const std::string name = line.substr(0, line.find_first_of(" {"));
        if (line.starts_with('#') || all.contains(name)) continue;
        for (const MetricSample& sample : page.all(name)) {
            all[name].push_back({{"labels", sample.labels}, {"value", sample.value}});
        }
    }
    return all.dump(2);
}

struct StatusOptions {
    std::string address = "127.0.0.1:9883";
    std::string authority;
    std::string name;
    std::string token;
    double every_s = 1;
    bool as_json = false;
};

MetricsAddress address_of(const StatusOptions& options) {
    auto address = parse_metrics_address(options.address);
    if (!address) {
        throw CommandError("`" + options.address +
                           "`: write HOST:PORT, as the broker's --metrics has it, or "
                           "https://HOST:PORT");
    }
    if (!address->is_https && !(options.authority + options.name + options.token).empty()) {
        throw CommandError("`" + options.address +
                           "`: --ca, --name and --token are for https://HOST:PORT");
    }
    if (!options.authority.empty()) address->authority = options.authority;
    if (!options.name.empty()) address->name = options.name;
    if (!options.token.empty()) address->token = options.token;
    return *address;
}

std::string fetch(const MetricsAddress& address) {
    try {
        return fetch_metrics(address, 5s);
    } catch (const std::runtime_error& error) {
        throw CommandError(error.what());
    }
}

void show_status(const StatusOptions& options) {
    using Clock = std::chrono::steady_clock;
    const MetricsAddress address = address_of(options);
    const std::string first = fetch(address);
    const MetricsPage before(first);
    if (!before.has("romano_broker_info")) {
        throw CommandError("what answers at " + options.address + " is no romano-broker");
    }
    if (options.as_json) {
        std::puts(page_as_json(before, first).c_str());
        return;
    }
    const auto since = Clock::now();
    std::this_thread::sleep_for(std::chrono::duration<double>(options.every_s));
    const MetricsPage now(fetch(address));
    const double seconds = std::chrono::duration<double>(Clock::now() - since).count();
    std::fputs(status_screen(before, now, seconds).c_str(), stdout);
}

}  // namespace

std::string status_screen(const MetricsPage& before, const MetricsPage& now, double seconds) {
    return Screen(before, now, seconds).text();
}

void add_status(CLI::App& program, int& exit_code) {
    auto options = std::make_shared<StatusOptions>();
    CLI::App& command = *program.add_subcommand(
        "status", "Show how a broker is doing: sessions, queues, rates, drops, its cluster");
    command.add_option("address", options->address, "Where the broker's --metrics are")
        ->type_name("[https://]HOST:PORT")
        ->capture_default_str();
    command
        .add_option("--ca", options->authority,
                    "https: the certificate of whoever vouches for the broker's (default: whom the "
                    "system believes)")
        ->type_name("FILE");
    command
        .add_option("--name", options->name,
                    "https: the name in the broker's certificate (default: the host's)")
        ->type_name("NAME");
    command
        .add_option("--token", options->token,
                    "https: a file of mode 600 with the broker's --metrics-token")
        ->type_name("FILE");
    command.add_option("--every", options->every_s, "Time over which rates are measured")
        ->type_name("SECONDS")
        ->check(real_number(0.1, 3600.0))
        ->capture_default_str();
    command.add_flag("--json", options->as_json, "Print all metrics as a JSON object");
    command.footer(status_examples);
    command.callback([options, &exit_code] {
        show_status(*options);
        exit_code = 0;
    });
}

}  // namespace romano::experiments
