#include "experiments/sweep/sweep_file.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <optional>
#include <set>
#include <span>
#include <sstream>

#include "election/elector.h"
#include "election/failure_detector.h"
#include "experiments/sweep/toml_table.h"

namespace romano::experiments {
namespace {

using Seconds = std::chrono::duration<double>;

constexpr std::array<std::pair<Pattern, std::string_view>, 3> pattern_names{{
    {Pattern::swarm, "swarm"},
    {Pattern::common, "common"},
    {Pattern::commands, "commands"},
}};

constexpr std::array<std::pair<World, std::string_view>, 4> world_names{{
    {World::processes, "processes"},
    {World::simulated, "simulated"},
    {World::radio, "radio"},
    {World::air, "air"},
}};

/// What brokers talk on among themselves. Processes have this machine's network, which is a wire;
/// the last one is there in a radio world alone.
constexpr std::array<std::string_view, 3> backbone_names{"wire", "wifi", "radio"};

constexpr std::int64_t slowest_baud = 1'200;
constexpr std::int64_t fastest_baud = 10'000'000;

constexpr std::array<std::string_view, 14> axis_names{
    "brokers", "robots",  "rate",     "payload",     "qos",        "elector", "detector",
    "acks",    "clients", "backbone", "router_baud", "robot_baud", "fault",   "seed"};

/// How clients speak; with keys, real processes alone.
constexpr std::array<std::string_view, 3> client_names{"plain", "protected", "dtls"};

/// How large a cell may be.
struct Most {
    std::uint32_t brokers;
    std::uint32_t robots;
    std::uint32_t payload_octets;  // one datagram holds them
    std::size_t client_names = 1;  // how many of them
    std::size_t backbone_names = 1;
};
constexpr Most most_in(World world) {
    switch (world) {
        case World::processes:
            return {32, 5000, 1400, client_names.size()};
        case World::simulated:
            return {100, 2000, 1400, 1, backbone_names.size() - 1};
        case World::radio:
            // 6LoWPAN's packets have 1280 octets at most
            return {64, 2000, 1000, 1, backbone_names.size()};
        case World::air:
            return {32, 2000, 1000};
    }
    return {};
}

constexpr const char* only_on_radio =
    "only a world on radio (`world = \"radio\"` or \"air\") has it";
constexpr const char* only_simulated =
    "only a simulated world (`world = \"simulated\"` or \"radio\") has it";

std::string seconds_text(Seconds seconds) {
    std::ostringstream text;
    text << seconds.count() << " s";
    return text.str();
}

struct Axes {
    std::vector<std::uint32_t> brokers;
    std::vector<std::uint32_t> robots;
    std::vector<double> rate;
    std::vector<std::uint32_t> payload;
    std::vector<QosMix> qos;
    std::vector<std::string> elector;
    std::vector<std::string> detector;
    std::vector<std::string> acks;
    std::vector<std::string> clients;
    std::vector<std::string> backbone;
    std::vector<std::string> router_baud;
    std::vector<std::string> robot_baud;
    std::vector<Fault> fault;
    std::vector<std::uint64_t> seed;
};

std::vector<std::uint32_t> counts(const TomlTable& table, const std::string& key,
                                  std::uint32_t fallback, std::uint32_t low, std::uint32_t high) {
    return table.axis<std::uint32_t>(key, fallback, [&, low, high](const toml::node& node) {
        return static_cast<std::uint32_t>(table.integer_in(node, key, low, high));
    });
}

std::vector<std::string> words(const TomlTable& table, const std::string& key,
                               const std::string& fallback,
                               std::span<const std::string_view> allowed) {
    return table.axis<std::string>(key, fallback, [&table, &key, allowed](const toml::node& node) {
        const auto word = node.value_exact<std::string>();
        if (!word || std::ranges::find(allowed, *word) == allowed.end()) {
            table.refuse(node, key, "allowed are " + listed(allowed));
        }
        return *word;
    });
}

QosMix read_qos(const TomlTable& table, const toml::node& node) {
    std::optional<QosMix> mix;
    if (const auto level = node.value_exact<std::int64_t>()) {
        mix = parse_qos_mix(std::to_string(*level));
    } else if (const auto text = node.value_exact<std::string>()) {
        mix = parse_qos_mix(*text);
    }
    if (!mix) table.refuse(node, "qos", "allowed are 0, 1, 2 or a mix such as \"0+1+2\"");
    return *mix;
}

std::string read_acks(const TomlTable& table, const toml::node& node, std::uint32_t most) {
    if (node.value_exact<std::string>() == "all") return "all";
    if (!node.is_integer()) {
        table.refuse(node, "acks",
                     "a number of peers from 0 to " + std::to_string(most) + ", or \"all\"");
    }
    return std::to_string(table.integer_in(node, "acks", 0, most));
}

/// A baud, or "none". Empty where there are no lines.
std::vector<std::string> bauds(const TomlTable& table, const std::string& key, World world) {
    if (!is_on_radio(world)) {
        if (const toml::node* node = table.find(key)) table.refuse(*node, key, only_on_radio);
        return {""};
    }
    return table.axis<std::string>(key, "115200", [&table, &key](const toml::node& node) {
        if (node.value_exact<std::string>() == "none") return std::string{"none"};
        const auto baud = node.value_exact<std::int64_t>();
        if (!baud || *baud < slowest_baud || *baud > fastest_baud) {
            table.refuse(node, key,
                         "a baud from " + std::to_string(slowest_baud) + " to " +
                             std::to_string(fastest_baud) + " or \"none\" is allowed");
        }
        return std::to_string(*baud);
    });
}

Axes read_axes(const TomlTable& table, World world) {
    table.allow_only(axis_names);
    const Most most = most_in(world);
    Axes axes;
    axes.brokers = counts(table, "brokers", 1, 1, most.brokers);
    axes.robots = counts(table, "robots", 10, 1, most.robots);
    axes.rate = table.axis<double>("rate", 1, [&table](const toml::node& node) {
        return table.number_in(node, "rate", 0.01, 100'000,
                               "messages per second from 0.01 to 100000 are allowed");
    });
    // A message carries its publisher, number and time: 16 octets.
    axes.payload = counts(table, "payload", 32, 16, most.payload_octets);
    axes.qos = table.axis<QosMix>(
        "qos", QosMix{{1}}, [&table](const toml::node& node) { return read_qos(table, node); });
    axes.elector = words(table, "elector", "component", election::elector_names());
    axes.detector = words(table, "detector", "link", election::detector_names());
    axes.acks = table.axis<std::string>("acks", "1", [&](const toml::node& node) {
        return read_acks(table, node, most.brokers - 1);
    });
    axes.clients =
        words(table, "clients", "plain", std::span{client_names}.first(most.client_names));
    axes.backbone =
        words(table, "backbone", "wire", std::span{backbone_names}.first(most.backbone_names));
    axes.router_baud = bauds(table, "router_baud", world);
    axes.robot_baud = bauds(table, "robot_baud", world);
    axes.fault = table.axis<Fault>("fault", Fault::none, [&table](const toml::node& node) {
        const auto word = node.value_exact<std::string>();
        const auto fault = fault_named(word.value_or(""));
        if (!fault) table.refuse(node, "fault", "allowed are " + fault_names());
        return *fault;
    });
    axes.seed = table.axis<std::uint64_t>("seed", 1, [&table](const toml::node& node) {
        return static_cast<std::uint64_t>(table.integer_in(node, "seed", 0, INT64_MAX));
    });
    return axes;
}

/// All combinations that make sense. With one broker there is nobody to take over: its faults are
/// left out, and what only a cluster has does not vary.
void append_cells(const Axes& axes, std::vector<Cell>& cells) {
    std::vector<Cell> points{Cell{}};
    const auto vary = [&points](const auto& values, const auto& set) {
        std::vector<Cell> varied;
        for (const Cell& point : points) {
            for (const auto& value : values) set(varied.emplace_back(point), value);
        }
        points = std::move(varied);
    };
    vary(axes.seed, [](Cell& cell, std::uint64_t seed) { cell.seed = seed; });
    vary(axes.robots, [](Cell& cell, std::uint32_t robots) { cell.robots = robots; });
    vary(axes.rate, [](Cell& cell, double rate) { cell.rate_per_s = rate; });
    vary(axes.payload, [](Cell& cell, std::uint32_t octets) { cell.payload_octets = octets; });
    vary(axes.qos, [](Cell& cell, const QosMix& qos) { cell.qos = qos; });
    vary(axes.brokers, [](Cell& cell, std::uint32_t brokers) { cell.brokers = brokers; });
    vary(axes.elector, [](Cell& cell, const std::string& name) { cell.elector = name; });
    vary(axes.detector, [](Cell& cell, const std::string& name) { cell.detector = name; });
    vary(axes.acks, [](Cell& cell, const std::string& acks) { cell.acks = acks; });
    vary(axes.clients, [](Cell& cell, const std::string& speech) { cell.clients = speech; });
    vary(axes.backbone, [](Cell& cell, const std::string& name) { cell.backbone = name; });
    vary(axes.router_baud, [](Cell& cell, const std::string& baud) { cell.router_baud = baud; });
    vary(axes.robot_baud, [](Cell& cell, const std::string& baud) { cell.robot_baud = baud; });
    vary(axes.fault, [](Cell& cell, Fault fault) { cell.fault = fault; });
    std::set<Cell> known(cells.begin(), cells.end());
    for (Cell& point : points) {
        if (point.brokers == 1) {
            if (point.fault != Fault::none) continue;
            point.elector = point.detector = point.acks = point.backbone = "";
        }
        if (known.insert(point).second) cells.push_back(point);
    }
}

Pattern read_pattern(const TomlTable& table) {
    const std::string word = table.word("pattern", "swarm");
    for (const auto& [pattern, name] : pattern_names) {
        if (name == word) return pattern;
    }
    table.refuse(*table.find("pattern"), "pattern", "allowed are swarm, common, commands");
}

World read_world(const TomlTable& table) {
    const std::string word = table.word("world", "processes");
    for (const auto& [world, name] : world_names) {
        if (name == word) return world;
    }
    table.refuse(*table.find("world"), "world", "allowed are processes, simulated, radio, air");
}

/// A number of milliseconds, or the least and the most.
void read_delay(const TomlTable& table, const std::string& key, SimulatedLink& link) {
    const toml::node* node = table.find(key);
    if (node == nullptr) return;
    constexpr const char* allowed =
        "milliseconds from 0 to 10000 are allowed, or the least and the most: [1, 5]";
    const toml::array* both = node->as_array();
    if (both == nullptr) {
        link.delay_min_ms = link.delay_max_ms = table.number_in(*node, key, 0, 10'000, allowed);
        return;
    }
    if (both->size() != 2) table.refuse(*node, key, allowed);
    link.delay_min_ms = table.number_in((*both)[0], key, 0, 10'000, allowed);
    link.delay_max_ms = table.number_in((*both)[1], key, link.delay_min_ms, 10'000, allowed);
}

SimulatedLink read_link(const TomlTable& table, const std::string& who, SimulatedLink link) {
    read_delay(table, who + "_delay_ms", link);
    const std::string loss = who + "_loss_percent";
    if (const toml::node* node = table.find(loss)) {
        link.loss_percent = table.number_in(*node, loss, 0, 50, "percent from 0 to 50 are allowed");
    }
    return link;
}

SweptRadio read_radio(const TomlTable& table) {
    SweptRadio radio;
    radio.channels =
        static_cast<std::uint32_t>(table.integer("radio_channels", radio.channels, 1, 16));
    if (const toml::node* node = table.find("router_distance_m")) {
        radio.router_distance_m = table.number_in(*node, "router_distance_m", 5, 10'000,
                                                  "metres from 5 to 10000 are allowed");
    }
    return radio;
}

/// What has no meaning in the other world would mislead.
void refuse_what_is_of_another_world(const TomlTable& table, World world) {
    constexpr std::array<std::string_view, 2> radio = {"radio_channels", "router_distance_m"};
    constexpr std::array<std::string_view, 6> simulated = {"client_delay_ms", "client_loss_percent",
                                                           "wire_delay_ms",   "wire_loss_percent",
                                                           "wifi_delay_ms",   "wifi_loss_percent"};
    constexpr std::array<std::string_view, 3> processes = {"domain_base", "network", "port"};
    const auto refuse = [&table](std::span<const std::string_view> keys, const char* why) {
        for (const std::string_view key : keys) {
            if (const toml::node* node = table.find(key)) {
                table.refuse(*node, std::string{key}, why);
            }
        }
    };
    if (!is_in_virtual_time(world)) {
        refuse(simulated, only_simulated);
    } else {
        refuse(processes, "a simulated world has no addresses on this machine");
    }
    if (!is_on_radio(world)) {
        refuse(radio, only_on_radio);
    }
}

/// What the sweep itself tells each broker.
constexpr std::array<std::string_view, 8> own_options = {"--name",      "--listen",  "--domain",
                                                         "--interface", "--elector", "--detector",
                                                         "--acks",      "--voters"};

/// Two octets of a loopback network: "127.50".
std::string read_network(const TomlTable& table) {
    if (table.find("network") == nullptr) return {};
    std::string network = table.word("network", "");
    int second = -1;
    int used = 0;
    const bool fine = std::sscanf(network.c_str(), "127.%3d%n", &second, &used) == 1 &&
                      static_cast<std::size_t>(used) == network.size() && second >= 0 &&
                      second <= 255;
    if (!fine) {
        table.refuse(*table.find("network"), "network",
                     "the first two octets of a loopback network, 127.0 to 127.255, are allowed");
    }
    return network;
}

SweepSettings read_settings(const TomlTable& table, const std::string& file_name) {
    for (const std::string_view axis : axis_names) {
        const toml::node* node = table.find(axis);
        if (node == nullptr) continue;
        table.refuse(*node, std::string{axis}, "it is an axis, and stands below [axes]");
    }
    table.allow_only({"name",
                      "world",
                      "pattern",
                      "repetitions",
                      "duration",
                      "fault_after",
                      "pause",
                      "drain",
                      "start_within",
                      "retry",
                      "publish_within",
                      "probe",
                      "broker_options",
                      "group",
                      "client_delay_ms",
                      "client_loss_percent",
                      "wire_delay_ms",
                      "wire_loss_percent",
                      "wifi_delay_ms",
                      "wifi_loss_percent",
                      "radio_channels",
                      "router_distance_m",
                      "domain_base",
                      "network",
                      "port",
                      "output",
                      "axes"});
    SweepSettings settings;
    settings.world = read_world(table);
    refuse_what_is_of_another_world(table, settings.world);
    settings.client_link = read_link(table, "client", settings.client_link);
    settings.wire = read_link(table, "wire", settings.wire);
    settings.wifi = read_link(table, "wifi", settings.wifi);
    settings.radio = read_radio(table);
    settings.name = table.word("name", std::filesystem::path{file_name}.stem().string());
    if (settings.name.find('/') != std::string::npos) {
        table.refuse(*table.find("name"), "name", "a name without / is allowed");
    }
    settings.pattern = read_pattern(table);
    settings.repetitions = static_cast<std::uint32_t>(table.integer("repetitions", 1, 1, 1000));
    settings.duration = table.seconds("duration", settings.duration);
    settings.fault_after = table.seconds("fault_after", settings.fault_after);
    settings.pause = table.seconds("pause", settings.pause);
    settings.drain = table.seconds("drain", settings.drain);
    settings.start_within = table.seconds("start_within", settings.start_within);
    settings.retry = table.seconds("retry", settings.retry);
    if (settings.retry < Seconds{0.05}) {
        table.refuse(*table.find("retry"), "retry", "at least 0.05 seconds are allowed");
    }
    settings.publish_within = table.seconds("publish_within", settings.publish_within);
    if (const toml::node* probe = table.find("probe")) {
        settings.probe_per_s = table.number_in(
            *probe, "probe", 0, 1000, "messages per second from 0 (no probe) to 1000 are allowed");
    }
    settings.broker_options = table.options("broker_options", own_options, "the sweep");
    settings.group = static_cast<std::uint32_t>(table.integer("group", settings.group, 1, 5000));
    // Cyclone DDS's ports are 7400 + 250 * domain: up to 65535.
    settings.domain_base = static_cast<std::uint32_t>(
        table.integer("domain_base", settings.domain_base, 0, 232 - domains_in_turn));
    settings.network = read_network(table);
    settings.port = static_cast<std::uint16_t>(table.integer("port", settings.port, 1, 65535));
    settings.output = table.word("output", "results/" + settings.name);
    return settings;
}

}  // namespace

std::string_view name_of(Pattern pattern) {
    for (const auto& [value, name] : pattern_names) {
        if (value == pattern) return name;
    }
    return "?";
}

std::string_view name_of(World world) {
    for (const auto& [value, name] : world_names) {
        if (value == world) return name;
    }
    return "?";
}

bool is_same_experiment(const Sweep& a, const Sweep& b) {
    SweepSettings elsewhere = b.settings;
    elsewhere.name = a.settings.name;
    elsewhere.output = a.settings.output;
    elsewhere.network = a.settings.network;
    elsewhere.domain_base = a.settings.domain_base;
    elsewhere.port = a.settings.port;
    return a.cells == b.cells && a.settings == elsewhere;
}

Sweep parse_sweep(std::string_view text, const std::string& file_name) {
    const toml::table document = parse_toml(text, file_name);
    const TomlTable table{document, file_name, ""};
    Sweep sweep{
        .settings = read_settings(table, file_name), .cells = {}, .text = std::string{text}};

    const World world = sweep.settings.world;
    std::vector<Cell> points;
    const toml::node* axes = table.find("axes");
    if (axes == nullptr) {
        throw SweepError(file_name +
                         ": no [axes]; at least `[axes]` with `brokers = [1]` is needed");
    }
    if (const toml::table* one = axes->as_table()) {
        append_cells(read_axes({*one, file_name, "axes."}, world), points);
    } else if (axes->is_array_of_tables()) {
        for (const toml::node& each : *axes->as_array()) {
            append_cells(read_axes({*each.as_table(), file_name, "axes."}, world), points);
        }
    } else {
        table.refuse(*axes, "axes", "a table [axes], or several [[axes]], are allowed");
    }

    const SweepSettings& settings = sweep.settings;
    const bool faults =
        std::ranges::any_of(points, [](const Cell& cell) { return cell.fault != Fault::none; });
    if (faults && settings.fault_after >= settings.duration) {
        throw SweepError(file_name + ": fault_after (" + seconds_text(settings.fault_after) +
                         ") must be less than duration (" + seconds_text(settings.duration) + ")");
    }
    for (const Cell& cell : points) {
        const auto last_kill = settings.fault_after + (cell.brokers - 2) * settings.pause;
        if (cell.fault != Fault::all_but_one || last_kill < settings.duration) continue;
        throw SweepError(file_name + ": all but one of " + std::to_string(cell.brokers) +
                         " brokers are killed after fault_after and so many times pause (" +
                         seconds_text(last_kill) + "): duration (" +
                         seconds_text(settings.duration) + ") must be longer");
    }
    for (std::uint32_t repetition = 1; repetition <= settings.repetitions; ++repetition) {
        for (Cell cell : points) {
            cell.number = static_cast<std::uint32_t>(sweep.cells.size() + 1);
            cell.repetition = repetition;
            sweep.cells.push_back(cell);
        }
    }
    if (sweep.cells.empty()) {
        throw SweepError(file_name + ": no cell to run: a fault needs at least 2 brokers");
    }
    return sweep;
}

Sweep read_sweep(const std::filesystem::path& file) {
    std::ifstream stream(file);
    std::ostringstream text;
    if (std::filesystem::is_directory(file) || !stream || !(text << stream.rdbuf())) {
        throw SweepError("cannot read the sweep file `" + file.string() + "`: " +
                         (std::filesystem::is_directory(file)
                              ? "it is a folder"
                              : (std::filesystem::exists(file) ? "it is empty or not readable"
                                                               : "no such file")));
    }
    return parse_sweep(text.str(), file.filename().string());
}

}  // namespace romano::experiments
