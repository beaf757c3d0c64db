#include "experiments/sweep/manifest.h"

#include <nlohmann/json.hpp>
#include <utility>

namespace romano::experiments {

namespace {

nlohmann::ordered_json to_json(const BrokerHost& host) {
    return {{"name", host.name},
            {"addresses", host.addresses},
            {"architecture", host.architecture},
            {"broker", host.broker_version}};
}

}  // namespace

std::string to_json(const Manifest& manifest, const Sweep& sweep) {
    using nlohmann::ordered_json;
    ordered_json cells = ordered_json::array();
    for (const Cell& cell : sweep.cells) {
        cells.push_back({{"cell", cell.number},
                         {"what", describe(cell)},
                         {"seed", cell.seed},
                         {"rerun", rerun_command(manifest, cell)}});
    }
    ordered_json hosts = ordered_json::array();
    for (const BrokerHost& host : manifest.hosts) hosts.push_back(to_json(host));
    const ordered_json json = {
        {"sweep", sweep.settings.name},
        {"world", name_of(sweep.settings.world)},
        {"started_utc", manifest.started_utc},
        {"romano",
         {{"version", manifest.build.version},
          {"commit", manifest.build.commit},
          {"compiler", manifest.build.compiler},
          {"build_type", manifest.build.type}}},
        {"broker", manifest.broker_version},
        {"machine",
         {{"cpu", manifest.machine.cpu},
          {"cores", manifest.machine.cores},
          {"memory_gib", manifest.machine.memory_gib},
          {"load_average_1_min", manifest.machine.load_average},
          {"kernel", manifest.machine.kernel},
          {"system", manifest.machine.system}}},
        {"hosts_file", manifest.hosts_file},
        {"hosts", hosts},
        {"sweep_file", manifest.sweep_file},
        {"sweep_text", sweep.text},
        {"cells", cells},
    };
    return json.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

Manifest parse_manifest(const std::string& text, const std::string& file) {
    const auto json = nlohmann::json::parse(text, nullptr, false);
    if (!json.is_object()) throw SweepError("`" + file + "` is no manifest of a sweep");
    const auto part = [&](const char* name) { return json.value(name, nlohmann::json::object()); };
    try {
        const auto build = part("romano");
        const auto machine = part("machine");
        std::vector<BrokerHost> hosts;
        for (const auto& host : json.value("hosts", nlohmann::json::array())) {
            hosts.push_back({.name = host.value("name", ""),
                             .addresses = host.value("addresses", std::vector<std::string>{}),
                             .architecture = host.value("architecture", ""),
                             .broker_version = host.value("broker", "")});
        }
        return {.build = {.version = build.value("version", ""),
                          .commit = build.value("commit", ""),
                          .compiler = build.value("compiler", ""),
                          .type = build.value("build_type", "")},
                .machine = {.cpu = machine.value("cpu", ""),
                            .cores = machine.value("cores", 0U),
                            .memory_gib = machine.value("memory_gib", 0.0),
                            .kernel = machine.value("kernel", ""),
                            .system = machine.value("system", ""),
                            .load_average = machine.value("load_average_1_min", 0.0)},
                .started_utc = json.value("started_utc", ""),
                .sweep_file = json.value("sweep_file", ""),
                .broker_version = json.value("broker", ""),
                .hosts_file = json.value("hosts_file", ""),
                .hosts = std::move(hosts)};
    } catch (const nlohmann::json::exception& wrong) {
        throw SweepError("`" + file + "` is no manifest of a sweep: " + wrong.what());
    }
}

std::string run_command(const Manifest& manifest) {
    const std::string command = "romano sweep '" + manifest.sweep_file + "'";
    if (manifest.hosts_file.empty()) return command;
    return command + " --hosts '" + manifest.hosts_file + "'";
}

std::string rerun_command(const Manifest& manifest, const Cell& cell) {
    return run_command(manifest) + " --cell " + std::to_string(cell.number);
}

}  // namespace romano::experiments
