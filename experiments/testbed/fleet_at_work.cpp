#include "experiments/testbed/fleet_at_work.h"

#include <chrono>
#include <set>
#include <stdexcept>
#include <thread>

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;

constexpr auto patience = 30s;  // for one answer
constexpr auto serves_within = 30s;

std::string with_port(const std::string& address, std::uint16_t port) {
    const bool is_v6 = address.find(':') != std::string::npos;
    return (is_v6 ? "[" + address + "]" : address) + ":" + std::to_string(port);
}

json ask(const Ssh& ssh, const json& words, const std::string& key) {
    boost::asio::io_context io{1};
    HostChannel channel{io, ssh, [](const json&) {}};
    return channel.ask(words, key, patience);
}

/// A sentence, unless all that is to serve there does.
std::string await_serving(const Ssh& ssh, const Host& host) {
    boost::asio::io_context io{1};
    HostChannel channel{io, ssh, [](const json&) {}};
    const auto deadline = std::chrono::steady_clock::now() + serves_within;
    while (true) {
        const json told =
            channel.ask({{"do", "kept"}, {"folder", host.folder}}, "programs", patience);
        std::string missing;
        bool has_ended = !told.at("kept").get<bool>();
        for (const json& each : told.at("programs")) {
            has_ended = has_ended || each.at("has_ended").get<bool>();
            const bool is_well = host.role == HostRole::robots || each.at("serves").get<bool>();
            if (is_well && !each.at("has_ended").get<bool>()) continue;
            missing = each.at("name").get<std::string>() +
                      " does not serve; it said: " + each.at("said").get<std::string>();
        }
        if (missing.empty() && has_ended) return "what was started has ended";
        if (missing.empty() || has_ended || std::chrono::steady_clock::now() > deadline)
            return missing;
        std::this_thread::sleep_for(100ms);
    }
}

using AtHost = std::function<std::string(const Ssh& ssh, const Host& host)>;

/// The troubles of those machines that `are` meant, with their names; `what` returns a sentence or
/// throws one.
std::vector<std::string> at_each(const Testbed& testbed, const Connections& connections,
                                 const std::function<bool(const Host&)>& are, const AtHost& what) {
    std::vector<std::string> troubles;
    for (std::size_t i = 0; i < testbed.hosts.size(); ++i) {
        const Host& host = testbed.hosts[i];
        if (!are(host)) continue;
        std::string trouble;
        try {
            const Ground ground = look_at_ground(connections[i]);
            trouble = !ground.trouble.empty() ? ground.trouble
                      : !ground.has_programs
                          ? "romano-host is not there yet: romano testbed install HOSTS"
                          : what(connections[i], host);
        } catch (const std::exception& error) {
            trouble = std::string{"romano-host there failed: "} + error.what();
        }
        if (!trouble.empty()) troubles.push_back(host.name + ": " + trouble);
    }
    return troubles;
}

json drop(const Ssh& ssh, const Host& host) {
    return ask(ssh, {{"do", "drop"}, {"folder", host.folder}}, "kept");
}

}  // namespace

KeptPrograms programs_of(const Testbed& testbed, const Host& host) {
    KeptPrograms kept{.folder = host.folder, .addresses = testbed.addresses(), .programs = {}};
    if (host.role == HostRole::robots) {
        ProgramOrder robots;
        robots.program = "romano-robot";
        robots.name = host.name;
        robots.arguments = {"--count", std::to_string(host.robots)};
        for (const std::string& address : kept.addresses) {
            robots.arguments.insert(robots.arguments.end(),
                                    {"--broker", with_port(address, testbed.port)});
        }
        robots.arguments.insert(robots.arguments.end(), testbed.robot_options.begin(),
                                testbed.robot_options.end());
        robots.trace = robots.name + ".txt";
        kept.programs.push_back(robots);
        return kept;
    }
    for (const std::string& address : host.addresses) {
        const std::size_t number = kept.programs.size();
        ProgramOrder broker;
        broker.number = static_cast<std::uint32_t>(number);
        broker.program = "romano-broker";
        broker.name = host.name + (number == 0 ? "" : "-" + std::to_string(number + 1));
        broker.arguments = {
            "--name",       broker.name,    "--listen", with_port(address, testbed.port),
            "--interface",  host.interface, "--domain", std::to_string(testbed.domain),
            "--allow-plain"};
        broker.arguments.insert(broker.arguments.end(), host.broker_options.begin(),
                                host.broker_options.end());
        broker.trace = broker.name + ".txt";
        kept.programs.push_back(broker);
    }
    return kept;
}

std::vector<std::string> start_fleet(const Testbed& testbed, const Connections& connections,
                                     const std::function<void(const std::string&)>& tell) {
    std::set<std::string> started;
    const auto start = [&](const Ssh& ssh, const Host& host) {
        const json order = programs_of(testbed, host);
        const json told = ask(ssh, {{"do", "keep"}, {"order", order}}, "kept");
        if (told.at("kept").get<bool>()) started.insert(host.name);
        return told.value("trouble", "");
    };
    const auto await = [&](const Ssh& ssh, const Host& host) {
        std::string trouble = await_serving(ssh, host);
        if (trouble.empty()) tell(host.name + ": runs");
        return trouble;
    };
    std::vector<std::string> troubles;
    for (const HostRole role : {HostRole::brokers, HostRole::robots}) {  // robots look for brokers
        const auto has_role = [role](const Host& host) { return host.role == role; };
        for (const AtHost& what : {AtHost{start}, AtHost{await}}) {
            if (troubles.empty()) troubles = at_each(testbed, connections, has_role, what);
        }
    }
    if (troubles.empty()) return troubles;
    (void)at_each(
        testbed, connections, [&](const Host& host) { return started.contains(host.name); },
        [](const Ssh& ssh, const Host& host) { return drop(ssh, host).value("trouble", ""); });
    return troubles;
}

std::vector<std::string> stop_fleet(const Testbed& testbed, const Connections& connections,
                                    const std::function<void(const std::string&)>& tell) {
    return at_each(
        testbed, connections, [](const Host&) { return true; },
        [&](const Ssh& ssh, const Host& host) {
            const json told = drop(ssh, host);
            std::string trouble = told.value("trouble", "");
            if (trouble.empty()) {
                tell(host.name + (told.value("was", false) ? ": stopped" : ": nothing ran"));
            }
            return trouble;
        });
}

}  // namespace romano::experiments
