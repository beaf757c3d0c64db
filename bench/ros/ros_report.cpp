#include "bench/ros/ros_report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "bench/ros/client_sizes.h"
#include "experiments/sweep/csv.h"

namespace romano::bench::ros {
namespace {

using experiments::PlotPanel;
using experiments::Section;
using experiments::SectionTable;
using experiments::SummaryTable;

struct Column {
    std::string head;
    std::string unit;
    std::string task;
    std::string figure;
    double scale = 1;
};

/// Three digits.
std::string text_of(std::optional<double> value) {
    if (!value) return "–";
    const double size = std::fabs(*value);
    const int decimals = size >= 100 || size < 1e-9 ? 0 : size >= 10 ? 1 : size >= 1 ? 2 : 3;
    char room[64];
    std::snprintf(room, sizeof room, "%.*f", decimals, *value);
    return room;
}

SectionTable table_of(const std::string& name, const Plan& plan, const Results& results,
                      const std::vector<Column>& columns) {
    SectionTable out{.name = name, .table = {}};
    out.table.head = {"contestant"};
    out.table.units = {""};
    for (const Column& column : columns) {
        out.table.head.push_back(column.head);
        out.table.units.push_back(column.unit);
    }
    for (const Contestant& one : plan.contestants) {
        std::vector<std::string> row{one.title()};
        bool has_any = false;
        for (const Column& column : columns) {
            auto value = results.get(one, column.task, column.figure);
            if (value) *value *= column.scale;
            has_any = has_any || value.has_value();
            row.push_back(text_of(value));
        }
        if (has_any) out.table.rows.push_back(std::move(row));
    }
    return out;
}

struct Line {  // of a plot
    std::string title;
    std::string x_label;
    std::string y_label;
    std::string figure;
    std::vector<std::pair<double, std::string>> tasks;  // by x
    bool reliable = true;
    bool log_y = true;
};

PlotPanel panel_of(const Plan& plan, const Results& results, const Line& line) {
    PlotPanel panel{.title = line.title,
                    .x_label = line.x_label,
                    .y_label = line.y_label,
                    .series = {},
                    .log_y = line.log_y};
    for (const Contestant& one : plan.contestants) {
        if (one.reliable != line.reliable) continue;
        experiments::PlotSeries series{.label = one.title(), .points = {}};
        for (const auto& [x, task] : line.tasks) {
            const auto y = results.get(one, task, line.figure);
            if (y) series.points.push_back({.x = x, .y = *y});
        }
        panel.series.push_back(std::move(series));
    }
    return panel;
}

std::string delay_task(int rate, int octets) {
    return "delay_" + std::to_string(rate) + "_" + std::to_string(octets);
}

Section delay_section(const Plan& plan, const Results& results) {
    Section section{
        .title = "One to one: delay",
        .words =
            "A node publishes, another one answers each message at once. One way: from the call "
            "that "
            "publishes to the call that hands the message over, on one clock. Round trip: there "
            "and "
            "back. Each node is a process on a machine of its own (a network namespace on one "
            "bridge), so the way between them is the kernel's; brokers add the way to and from "
            "them. With several brokers the two nodes are at different ones, and a message of QoS "
            "1 is held by a second broker before its publisher is answered. Lost: not heard half a "
            "second after the measurement; what still waits in a queue is among it. An MQTT-SN "
            "client has one message of QoS 1 on its way at a time, so where the answer takes more "
            "than a millisecond it publishes fewer than 1,000 a second, and the others wait.",
        .tables = {},
        .figure = {.name = "delay", .panels = {}}};
    for (const int octets : {32, 512}) {
        if (rates_of(plan, octets).empty()) continue;
        std::vector<Column> columns;
        for (const int rate : rates_of(plan, octets)) {
            const std::string task = delay_task(rate, octets);
            const std::string at = ", " + std::to_string(rate) + "/s";
            columns.push_back({"one way p50" + at, "ms", task, "one_way_p50_ms"});
            columns.push_back({"p99" + at, "ms", task, "one_way_p99_ms"});
            columns.push_back({"round trip p50" + at, "ms", task, "round_trip_p50_ms"});
            columns.push_back({"p99" + at, "ms", task, "round_trip_p99_ms"});
            columns.push_back({"lost" + at, "messages", task, "lost"});
        }
        section.tables.push_back(
            table_of("delay_" + std::to_string(octets) + "_octets", plan, results, columns));
    }
    std::vector<std::pair<double, std::string>> tasks;
    for (const int rate : rates_of(plan, 32)) {
        tasks.emplace_back(std::log10(rate), delay_task(rate, 32));
    }
    const std::string x_label = "messages a second, 10 to the power of";
    for (const bool reliable : {true, false}) {
        const std::string kind = reliable ? "reliable" : "best effort";
        section.figure.panels.push_back(panel_of(plan, results,
                                                 {.title = "32 octets, " + kind + ": median",
                                                  .x_label = x_label,
                                                  .y_label = "one-way delay, ms",
                                                  .figure = "one_way_p50_ms",
                                                  .tasks = tasks,
                                                  .reliable = reliable}));
        section.figure.panels.push_back(panel_of(plan, results,
                                                 {.title = "32 octets, " + kind + ": 99 %",
                                                  .x_label = x_label,
                                                  .y_label = "one-way delay, ms",
                                                  .figure = "one_way_p99_ms",
                                                  .tasks = tasks,
                                                  .reliable = reliable}));
    }
    return section;
}

Section cost_section(const Plan& plan, const Results& results) {
    const int rate = plan.quick ? 100 : 1000;
    const std::string fast = std::to_string(rate) + "/s";
    const std::string task = delay_task(rate, 32);
    const std::string slow = delay_task(100, 32);
    return {
        .title = "What a message costs",
        .words =
            "Of 32 octets, one to one. Published: of what was due at " + fast +
            "; less says that the node, or the call that publishes, was busy. CPU: both nodes "
            "together, and master or brokers, at " +
            fast +
            " each way. Octets and packets on the wire at 100/s, from the IP header on, of all "
            "that nodes send or get: discovery, acknowledgements and heartbeats included. "
            "Between brokers: what they say to each other, which with 3 and 5 is "
            "mostly beacons that are there without messages.",
        .tables = {table_of("cost", plan, results,
                            {{"published at " + fast, "%", task, "published_percent"},
                             {"node CPU a message", "us", task, "node_cpu_us_a_message"},
                             {"infrastructure CPU", "us", task, "infrastructure_cpu_us_a_message"},
                             {"octets a message", "", slow, "octets_a_message"},
                             {"packets a message", "", slow, "packets_a_message"},
                             {"of 512 octets", "octets", delay_task(100, 512), "octets_a_message"},
                             {"between brokers", "octets/s", slow, "backbone_octets_a_s"}})},
        .figure = {}};
}

Section fan_out_section(const Plan& plan, const Results& results) {
    Section section{
        .title = "One to many",
        .words =
            "20 messages of 32 octets a second to so many subscribers, each on a machine of its "
            "own. Last: "
            "when the last of them has it. DDS sends one multicast packet to all where it can; "
            "TCP and MQTT(-SN) send one to each.",
        .tables = {},
        .figure = {.name = "fan_out", .panels = {}}};
    std::vector<Column> columns;
    std::vector<std::pair<double, std::string>> tasks;
    for (const int subscribers : fan_outs_of(plan)) {
        const std::string task = "fan_out_" + std::to_string(subscribers);
        tasks.emplace_back(subscribers, task);
        const std::string to = ", " + std::to_string(subscribers);
        columns.push_back({"last p50" + to, "ms", task, "last_p50_ms"});
        columns.push_back({"last p99" + to, "ms", task, "last_p99_ms"});
        columns.push_back({"octets" + to, "", task, "octets_a_message"});
        columns.push_back({"lost" + to, "deliveries", task, "lost"});
    }
    section.tables.push_back(table_of("fan_out", plan, results, columns));
    for (const auto& [title, y_label, figure] :
         {std::array{"the last has it: median", "delay, ms", "last_p50_ms"},
          std::array{"on the wire", "octets a message", "octets_a_message"},
          std::array{"nodes' CPU", "us a message", "node_cpu_us_a_message"}}) {
        section.figure.panels.push_back(panel_of(plan, results,
                                                 {.title = title,
                                                  .x_label = "subscribers",
                                                  .y_label = y_label,
                                                  .figure = figure,
                                                  .tasks = tasks}));
    }
    return section;
}

Section telemetry_section(const Plan& plan, const Results& results) {
    return {.title = "Telemetry of " + std::to_string(robots_of(plan)) + " robots",
            .words =
                "Each robot publishes 32 octets on its own topic ten times a second; one observer "
                "hears "
                "all. CPU of all nodes; memory of master or brokers.",
            .tables = {table_of(
                "telemetry", plan, results,
                {{"delay p50", "ms", "telemetry", "one_way_p50_ms"},
                 {"p99", "ms", "telemetry", "one_way_p99_ms"},
                 {"lost", "messages", "telemetry", "lost"},
                 {"node CPU a message", "us", "telemetry", "node_cpu_us_a_message"},
                 {"infrastructure CPU", "% of a core", "telemetry", "infrastructure_cpu_percent"},
                 {"octets a message", "", "telemetry", "octets_a_message"},
                 {"infrastructure memory", "MiB", "telemetry", "infrastructure_mib"}})},
            .figure = {}};
}

Section idle_section(const Plan& plan, const Results& results) {
    return {.title = "A node that says nothing",
            .words =
                "It publishes on one topic and hears one, of one other node. Joining: its first "
                "five seconds. "
                "Then what a minute takes: octets that it sends or gets, discovery "
                "included; its CPU; memory that is resident; and what all masters or brokers "
                "together take. "
                "A real ROS 2 "
                "node has some ten endpoints more (parameters, rosout), which are not here.",
            .tables = {table_of(
                "idle", plan, results,
                {{"joining", "octets", "idle", "join_octets"},
                 {"idle", "octets/min", "idle", "idle_octets_a_minute"},
                 {"CPU", "ms/min", "idle", "idle_cpu_ms_a_minute"},
                 {"node memory", "MiB", "idle", "node_mib"},
                 {"infrastructure memory", "MiB", "idle", "infrastructure_mib"},
                 {"infrastructure CPU", "% of a core", "idle", "infrastructure_cpu_percent"},
                 {"between brokers", "octets/min", "idle", "backbone_octets_a_minute"}})},
            .figure = {}};
}

Section start_section(const Plan& plan, const Results& results) {
    return {.title = "Start-up until the first message",
            .words =
                "Subscriber and publisher (100/s) are started together. Cold: at the same moment "
                "as master or "
                "brokers. Warm: these run already. Median of three.",
            .tables = {table_of(
                "start", plan, results,
                {{"cold", "ms", "start", "cold_ms"}, {"warm", "ms", "start", "warm_ms"}})},
            .figure = {}};
}

Section deaths_section(const Plan& plan, const Results& results) {
    const std::string task = "death_of_infrastructure";
    return {
        .title = "When something dies",
        .words =
            "100 messages a second; kill -9. First table: the master, or the publisher's broker, "
            "which is "
            "started again after three seconds where it is the only one. A newcomer subscribes one "
            "second "
            "after the death. Silence: the longest time without a message at a subscriber "
            "that was there before. Nodes: how many of publisher and newcomer had to be restarted "
            "until the "
            "newcomer heard something. (ROS 2 has nothing in the middle that could die.) "
            "Second table: a subscriber dies and comes back after a second; lost is what was "
            "published meanwhile "
            "and until it heard again. MQTT clients here begin with clean sessions: a "
            "session that is kept (or transient-local topics) loses less.",
        .tables = {table_of("death_of_infrastructure", plan, results,
                            {{"longest silence", "ms", task, "longest_silence_ms"},
                             {"lost", "messages", task, "lost"},
                             {"newcomer hears after", "ms", task, "newcomer_ms"},
                             {"master or broker restarted", "", task, "infrastructure_restarts"},
                             {"nodes restarted", "", task, "node_restarts"}}),
                   table_of(
                       "death_of_peer", plan, results,
                       {{"hears again after", "ms", "death_of_peer", "again_ms"},
                        {"lost to it", "messages", "death_of_peer", "lost"},
                        {"lost to another", "messages", "death_of_peer", "bystander_lost"},
                        {"silence at the other", "ms", "death_of_peer", "bystander_silence_ms"}})},
        .figure = {}};
}

Section radio_section(const Plan& plan, const Results& results) {
    const std::string task = delay_task(100, 32);
    return {
        .title = "On IEEE 802.15.4",
        .words =
            "Computed from the packets that were captured, as if each that a node sends or gets "
            "went once over the "
            "air at 250 kbit/s: frames of 6LoWPAN with compressed headers and fragments, "
            "acknowledgements, preambles; no waiting for the channel, no repetitions, which makes "
            "all look better "
            "than they are. ARP and IGMP have no part in it. Brokers are at border routers, joined "
            "by cable. "
            "A channel carries 1,000 ms of air a second for all of its nodes together; idle: of "
            "one node "
            "that says nothing, per minute.",
        .tables = {table_of("radio", plan, results,
                            {{"32 octets", "frames", task, "frames_a_message"},
                             {"32 octets", "ms of air", task, "air_ms_a_message"},
                             {"512 octets", "frames", delay_task(100, 512), "frames_a_message"},
                             {"512 octets", "ms of air", delay_task(100, 512), "air_ms_a_message"},
                             {"joining", "ms of air", "idle", "join_air_ms"},
                             {"idle", "frames/min", "idle", "idle_frames_a_minute"},
                             {"idle", "ms of air/min", "idle", "idle_air_ms_a_minute"}})},
        .figure = {}};
}

/// 5140: "5,140".
std::string octets_text(int octets) {
    std::string text = std::to_string(octets);
    if (text.size() > 3) text.insert(text.size() - 3, ",");
    return text;
}

std::vector<std::string> own_client_row(const std::string& what,
                                        const std::optional<ClientSize>& size,
                                        const std::string& image) {
    if (!size) return {what, "–", "–", "not built: there is no arm-none-eabi-g++"};
    return {what, octets_text(size->flash_octets), octets_text(size->ram_octets), image};
}

Section smallest_client_section() {
    return {
        .title = "The smallest client",
        .words =
            "Octets of flash and RAM on a Cortex-M. Ours are those of the images that "
            "were built with this program (firmware/README.md), stack not included. "
            "Micro XRCE-DDS and micro-ROS are quoted, not measured; they need an agent on "
            "a bigger machine, as our client needs a broker. ROS 1 (rosserial aside) and "
            "the DDS of ROS 2 have no client for such chips.",
        .tables = {{.name = "smallest_client",
                    .table = {.head = {"client", "flash", "RAM", "source"},
                              .units = {"", "octets", "octets", ""},
                              .rows = {own_client_row("ROMANO: MQTT-SN client, QoS 0 to 2",
                                                      size_of_client, "footprint_client.elf"),
                                       own_client_row("ROMANO: client, node, mailbox, discovery",
                                                      size_of_node, "footprint_node.elf"),
                                       {"Micro XRCE-DDS: publisher and subscriber",
                                        "less than 75 kB", "2.5 kB",
                                        "micro-ros.github.io/docs/concepts/middleware/"
                                        "Micro_XRCE-DDS/"},
                                       {"micro-ROS, beyond that: a publisher or subscriber", "–",
                                        "550 to 600, and 2,048 for each message kept",
                                        "docs.vulcanexus.org, micro-ROS, Benchmarking"}}}}},
        .figure = {}};
}

/// One question of the verdict.
struct Question {
    std::string what;
    std::string task;
    std::string figure;
    std::string unit;
    double equal_within = 0.1;  // of the smaller one
};

/// Who lost more than a hundredth saved CPU, octets and time.
bool did_its_work(const Results& results, const Contestant& one, const std::string& task) {
    const auto messages = results.get(one, task, "messages");
    return !messages || results.get(one, task, "lost").value_or(0) <= 0.01 * *messages;
}

/// The better of the contestants of a kind: the least value.
struct Best {
    std::string who;
    double value = 0;
};

std::optional<Best> best_of(const Plan& plan, const Results& results, const Question& question,
                            bool of_ros) {
    std::optional<Best> best;
    for (const Contestant& one : plan.contestants) {
        const bool is_ros = one.system == System::ros1 || one.system == System::cyclone ||
                            one.system == System::fastdds;
        if (!one.reliable || is_ros != of_ros || one.system == System::mosquitto) continue;
        const auto value = results.get(one, question.task, question.figure);
        if (!did_its_work(results, one, question.task)) continue;
        if (value && (!best || *value < best->value)) best = Best{one.title(), *value};
    }
    return best;
}

Section verdict_section(const Plan& plan, const Results& results) {
    const int fast = plan.quick ? 100 : 1000;
    const std::string most = "fan_out_" + std::to_string(fan_outs_of(plan).back());
    const std::vector<Question> questions{
        {"Delay, one to one, median at 100/s", delay_task(100, 32), "one_way_p50_ms", "ms"},
        {"Delay, one to one, 99 % at 100/s", delay_task(100, 32), "one_way_p99_ms", "ms"},
        {"Round trip, median at " + std::to_string(fast) + "/s", delay_task(fast, 32),
         "round_trip_p50_ms", "ms"},
        {"Delay of 512 octets, median at 100/s", delay_task(100, 512), "one_way_p50_ms", "ms"},
        {"The last of many subscribers has it, median", most, "last_p50_ms", "ms"},
        {"On the wire to many subscribers", most, "octets_a_message", "octets/message"},
        {"On the wire, one to one, 32 octets", delay_task(100, 32), "octets_a_message",
         "octets/message"},
        {"CPU of nodes a message", delay_task(fast, 32), "node_cpu_us_a_message", "us"},
        {"CPU of master or brokers a message", delay_task(fast, 32),
         "infrastructure_cpu_us_a_message", "us"},
        {"Memory of a node", "idle", "node_mib", "MiB"},
        {"Memory of master or brokers", "idle", "infrastructure_mib", "MiB"},
        {"A node joins", "idle", "join_octets", "octets"},
        {"An idle node", "idle", "idle_octets_a_minute", "octets/min"},
        {"Start-up with everything, until the first message", "start", "cold_ms", "ms"},
        {"Start-up of nodes alone, until the first message", "start", "warm_ms", "ms"},
        {"Master or broker dies: longest silence", "death_of_infrastructure", "longest_silence_ms",
         "ms"},
        {"A subscriber that died hears again", "death_of_peer", "again_ms", "ms"},
        {"Air of a message of 32 octets (802.15.4)", delay_task(100, 32), "air_ms_a_message", "ms"},
        {"Air of an idle node (802.15.4)", "idle", "idle_air_ms_a_minute", "ms/min"},
    };
    SectionTable out{.name = "verdict", .table = {}};
    out.table.head = {"question",       "unit", "best of ROS",   "",
                      "best of ROMANO", "",     "in plain words"};
    for (const Question& question : questions) {
        const auto ros = best_of(plan, results, question, true);
        const auto ours = best_of(plan, results, question, false);
        if (!ros || !ours) continue;
        const bool ros_is_better = ros->value < ours->value;
        const double less = std::min(ros->value, ours->value);
        const double more = std::max(ros->value, ours->value);
        std::string words = "about the same";
        if (more > less * (1 + question.equal_within)) {
            words = ros_is_better ? "ROS is better" : "ROMANO is better";
            if (less > 0) words += ", " + text_of(more / less) + " times";
        }
        out.table.rows.push_back({question.what, question.unit, text_of(ros->value), ros->who,
                                  text_of(ours->value), ours->who, words});
    }
    return {
        .title = "Who is better in what",
        .words =
            "The best of ROS 1 (TCP) and ROS 2 (reliable) beside the best of ROMANO with 1, 3 or 5 "
            "brokers (QoS 1); less is better. Differences below a tenth count as none; who lost "
            "more "
            "than a hundredth of its messages is left out. ROS 2 needs nothing in the middle: no "
            "machine to choose, to pay for and to lose. What no number here says: ROS has types, "
            "services, actions, parameters, tools and thousands of packages; ROMANO has messages.",
        .tables = {std::move(out)},
        .figure = {}};
}

}  // namespace

std::optional<double> Results::get(const Contestant& contestant, const std::string& task,
                                   const std::string& figure) const {
    const auto of_one = all_.find(contestant.full_name());
    if (of_one == all_.end()) return std::nullopt;
    const auto of_task = of_one->second.find(task);
    return of_task == of_one->second.end() ? std::nullopt : of_task->second.get(figure);
}

std::vector<Section> sections_of(const Plan& plan, const Results& results) {
    const auto wants = [&](const char* part) {
        return std::ranges::find(plan.parts, part) != plan.parts.end();
    };
    std::vector<Section> all{verdict_section(plan, results)};
    if (wants("delay")) {
        all.push_back(delay_section(plan, results));
        all.push_back(cost_section(plan, results));
    }
    if (wants("fan_out")) all.push_back(fan_out_section(plan, results));
    if (wants("telemetry")) all.push_back(telemetry_section(plan, results));
    if (wants("idle")) all.push_back(idle_section(plan, results));
    if (wants("start")) all.push_back(start_section(plan, results));
    if (wants("deaths")) all.push_back(deaths_section(plan, results));
    if (wants("delay") || wants("idle")) all.push_back(radio_section(plan, results));
    all.push_back(smallest_client_section());
    return all;
}

std::string to_csv(const Results& results) {
    std::string text = experiments::csv_line({"contestant", "task", "figure", "value"});
    for (const auto& [contestant, tasks] : results.all()) {
        for (const auto& [task, figures] : tasks) {
            for (const auto& [figure, value] : figures.all()) {
                text += experiments::csv_line(
                    {contestant, task, figure, experiments::csv_number(value)});
            }
        }
    }
    return text;
}

std::string to_json(const Results& results) {
    nlohmann::ordered_json json;
    for (const auto& [contestant, tasks] : results.all()) {
        for (const auto& [task, figures] : tasks) json[contestant][task] = figures.all();
    }
    return json.dump(2) + "\n";
}

}  // namespace romano::bench::ros
