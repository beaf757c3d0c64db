#include "experiments/testbed/examination.h"

#include <algorithm>
#include <chrono>
#include <sstream>
#include <stdexcept>

#include "experiments/process/shell_word.h"
#include "experiments/sweep/build_info.h"

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;

constexpr auto answers_within = 30s;  // for one answer
constexpr auto multicast_patience = 2s;

double unix_time_s() {
    return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch())
        .count();
}

/// One machine with romano-host, while it is looked at.
struct Patient {
    const Host& host;
    HostSeen& seen;
    std::unique_ptr<HostChannel> channel;

    void begin_asking(const json& words, const std::string& key) const {
        if (channel) channel->begin_asking(words, key);
    }
    std::optional<json> ask(const json& words, const std::string& key) {
        begin_asking(words, key);
        return await_answer();
    }
    /// Empty when it has trouble: then it is looked at no more.
    std::optional<json> await_answer() {
        if (!channel) return std::nullopt;
        try {
            return channel->await_answer(answers_within);
        } catch (const std::exception& error) {
            seen.trouble = std::string{"romano-host there failed: "} + error.what() +
                           "; is it of this version? romano testbed install HOSTS";
            channel.reset();
            return std::nullopt;
        }
    }

    void compare_clock() {
        // The first answer waits until the program has started there.
        (void)ask({{"do", "time"}}, "time_s");
        const double asked = unix_time_s();
        const auto told = ask({{"do", "time"}}, "time_s");
        if (!told || !(*told)["time_s"].is_number()) return;
        const double way_s = (unix_time_s() - asked) / 2;
        seen.clock_offset_s = (*told)["time_s"].get<double>() - (asked + way_s);
        seen.clock_uncertainty_s = way_s;
    }

    void ask_for_facts(std::uint16_t port) const {
        const FactsRequest request{
            .interface = host.interface, .addresses = host.addresses, .port = port};
        begin_asking({{"do", "facts"}, {"of", request}}, "facts");
    }

    void take_facts() {
        const auto told = await_answer();
        if (!told) return;
        try {
            seen.facts = (*told)["facts"].get<HostFacts>();
        } catch (const json::exception&) {
            seen.trouble =
                "romano-host there is of another version; make them alike: romano testbed install "
                "HOSTS";
            channel.reset();
        }
    }

    void listen() {
        const auto told =
            ask({{"do", "listen"}, {"name", host.name}, {"interface", host.interface}}, "trouble");
        if (!told) return;
        seen.multicast_trouble = told->value("trouble", "");
        seen.longest_octets = told->value("longest_octets", 0);
    }

    void shout() {
        const auto told = ask({{"do", "shout"}}, "trouble");
        if (told && seen.multicast_trouble.empty()) {
            seen.multicast_trouble = told->value("trouble", "");
        }
    }

    void hear() {
        const auto told = ask({{"do", "heard"}}, "heard");
        if (told) seen.heard = told->value("heard", std::map<std::string, int>{});
    }
};

/// Each hears each other, as far as they were there at all.
bool is_all_heard(const std::vector<Patient>& patients) {
    return std::ranges::all_of(patients, [&](const Patient& to) {
        return !to.channel || std::ranges::all_of(patients, [&](const Patient& from) {
            if (!from.channel || &from == &to) return true;
            const auto found = to.seen.heard.find(from.host.name);
            return found != to.seen.heard.end() && found->second >= from.seen.longest_octets;
        });
    });
}

void try_multicast(std::vector<Patient>& patients) {
    for (Patient& each : patients) each.listen();
    for (Patient& each : patients) each.shout();
    const auto deadline = std::chrono::steady_clock::now() + multicast_patience;
    do {
        for (Patient& each : patients) each.hear();
    } while (!is_all_heard(patients) && std::chrono::steady_clock::now() < deadline);
}

std::string what_to_do_about(const std::string& said, const Host& host) {
    if (said.find("Host key verification failed") != std::string::npos) {
        return "its host key is unknown here: connect once by hand, ssh " + host.ssh +
               ", and compare the key";
    }
    if (said.find("Permission denied") != std::string::npos) {
        return "ssh may not log in (" + said + "); copy your key there: ssh-copy-id " + host.ssh;
    }
    return "ssh cannot reach it (" + said + "); is it on, and `ssh` in the hosts file right?";
}

}  // namespace

Connections::Connections(const Testbed& testbed) {
    for (const Host& host : testbed.hosts) all_.push_back(std::make_unique<Ssh>(host, folder_));
}

std::string own_version() {
    const BuildInfo build = build_info();
    return std::string{build.version} + " (" + std::string{build.commit} + ")";
}

Ground look_at_ground(const Ssh& ssh) {
    Ground ground;
    if (const std::string said = ssh.connect(); !said.empty()) {
        ground.trouble = what_to_do_about(said, ssh.host());
        return ground;
    }
    const std::string program = shell_word(ssh.host().folder + "/romano-host");
    const ProgramEnd end = ssh.run(
        "uname -m; if [ \"$(id -u)\" = 0 ] || sudo -n true 2>/dev/null; then echo root; "
        "else echo user; fi; if [ -x " +
        program + " ] || command -v romano-host >/dev/null; then echo programs; fi");
    std::istringstream words(end.output);
    std::string who, programs;
    words >> ground.architecture >> who >> programs;
    ground.has_programs = programs == "programs";
    if (who == "root") return ground;
    ground.trouble =
        who == "user"
            ? "`sudo -n` does not work there, and brokers must be root to take addresses over; "
              "allow it (sudo visudo: USER ALL=(ALL) NOPASSWD: ALL), or log in as root"
            : "its shell does not understand what is asked (" +
                  end.output.substr(0, end.output.find('\n')) + "); give the user /bin/sh";
    return ground;
}

std::vector<HostSeen> examine(const Testbed& testbed, const Connections& connections,
                              std::uint16_t port,
                              const std::function<void(const std::string&)>& tell) {
    std::vector<HostSeen> seen(testbed.hosts.size());
    boost::asio::io_context io{1};
    std::vector<Patient> patients;
    for (std::size_t i = 0; i < testbed.hosts.size(); ++i) {
        const Host& host = testbed.hosts[i];
        tell("looking at " + host.name);
        const Ground ground = look_at_ground(connections[i]);
        seen[i].trouble = ground.trouble;
        if (ground.trouble.empty() && !ground.has_programs) {
            seen[i].trouble =
                "romano-host is not there yet, which would say the rest: romano testbed install "
                "HOSTS";
        }
        if (!seen[i].trouble.empty()) continue;
        Patient patient{host, seen[i],
                        std::make_unique<HostChannel>(io, connections[i], [](const json&) {})};
        patient.compare_clock();
        patients.push_back(std::move(patient));
    }
    for (const Patient& each : patients) each.ask_for_facts(port);  // each looks for a second
    for (Patient& each : patients) each.take_facts();
    for (Patient& each : patients) {
        if (each.host.role == HostRole::robots) each.channel.reset();  // brokers alone multicast
    }
    tell("trying multicast");
    try_multicast(patients);
    return seen;
}

}  // namespace romano::experiments
