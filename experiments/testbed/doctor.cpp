#include "experiments/testbed/doctor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <set>
#include <string_view>

namespace romano::experiments {
namespace {

constexpr std::int64_t least_free_mib = 100;
constexpr double most_clock_offset_s = 0.5;

/// Settings that all brokers of a cluster must have alike.
constexpr std::array<std::string_view, 10> alike = {
    "--predefined",    "--profile",  "--beacon-ms", "--detection-timeout-ms",
    "--phi-threshold", "--retry-ms", "--retries",   "--detector",
    "--elector",       "--acks"};

class Doctor {
public:
    Doctor(const Testbed& testbed, const std::vector<HostSeen>& seen,
           const std::string& own_version)
        : testbed_(testbed), seen_(seen), own_version_(own_version) {}

    std::vector<HostFinding> look() {
        for (std::size_t i = 0; i < testbed_.hosts.size(); ++i) {
            const Host& host = testbed_.hosts[i];
            const HostSeen& seen = seen_[i];
            if (!seen.trouble.empty()) problem(host, "reach", seen.trouble);
            if (seen.facts) look_at(host, seen, *seen.facts);
        }
        look_at_programs();
        look_at_settings();
        look_at_multicast();
        return std::move(findings_);
    }

private:
    void problem(const Host& host, const char* about, const std::string& sentence) {
        findings_.push_back({host.name, about, true, sentence});
    }
    void warning(const Host& host, const char* about, const std::string& sentence) {
        findings_.push_back({host.name, about, false, sentence});
    }

    void look_at(const Host& host, const HostSeen& seen, const HostFacts& facts) {
        if (facts.free_mib < least_free_mib) {
            problem(host, "disk",
                    "/tmp has " + std::to_string(facts.free_mib) +
                        " MiB free, and traces need 100; make room there");
        }
        look_at_clock(host, seen);
        if (host.role == HostRole::robots) return;
        if (!facts.taken_by.empty()) {
            warning(host, "use",
                    "it is taken by " + facts.taken_by +
                        "; before a sweep: romano testbed stop HOSTS, or wait for that sweep");
        }
        look_at_interface(host, facts);
        look_at_rights(host, facts);
        if (facts.has_interface) look_at_addresses(host, facts);
        if (!facts.port_user.empty() && facts.taken_by.empty()) {
            problem(host, "port",
                    "the UDP port is in use by " + facts.port_user +
                        "; stop that program, or take another `port`");
        }
    }

    void look_at_clock(const Host& host, const HostSeen& seen) {
        if (!seen.clock_offset_s) return;
        const double off = std::abs(*seen.clock_offset_s) - seen.clock_uncertainty_s;
        if (off <= most_clock_offset_s) return;
        std::array<char, 160> text{};
        std::snprintf(text.data(), text.size(),
                      "its clock is %.1f s %s this machine's, so that times in traces do not fit; "
                      "on both: sudo timedatectl set-ntp true",
                      std::abs(*seen.clock_offset_s),
                      *seen.clock_offset_s > 0 ? "ahead of" : "behind");
        warning(host, "clock", text.data());
    }

    void look_at_interface(const Host& host, const HostFacts& facts) {
        const std::string name = "interface `" + host.interface + "`";
        if (!facts.has_interface) {
            problem(host, "interface",
                    "it has no " + name + "; `ip link` there names those that it has");
        } else if (!facts.is_up) {
            problem(host, "interface", name + " is down; plug in its cable or join its network");
        } else if (!facts.can_multicast) {
            problem(host, "interface",
                    name + " cannot multicast, as brokers must: sudo ip link set dev " +
                        host.interface + " multicast on");
        } else if (facts.own_addresses.empty()) {
            problem(host, "interface",
                    name +
                        " has no address of its own, at which brokers could speak to each "
                        "other; give it one");
        }
    }

    void look_at_rights(const Host& host, const HostFacts& facts) {
        if (!facts.may_add_addresses) {
            problem(host, "rights",
                    "its brokers may not take addresses over (CAP_NET_ADMIN); let `sudo -n` work "
                    "for the ssh user, or log in as root");
        }
        if (!facts.may_announce) {
            problem(host, "rights",
                    "its brokers may not announce addresses to neighbours (CAP_NET_RAW); let "
                    "`sudo -n` work for the ssh user, or log in as root");
        }
        if (!facts.may_cut) {
            warning(host, "rights",
                    "fault `cut` is not possible there without nft: sudo apt install nftables");
        }
    }

    void look_at_addresses(const Host& host, const HostFacts& facts) {
        for (const AddressFacts& known : facts.addresses) {
            const std::string address = "address " + known.address;
            if (known.is_own) {
                problem(host, "address",
                        address +
                            " is the machine's own, and one that moves must not be; choose a free "
                            "one of that network");
            } else if (!known.is_in_network) {
                problem(host, "address",
                        address + " lies in no network of interface `" + host.interface +
                            "`; choose one beside " +
                            (facts.own_addresses.empty() ? "its own" : facts.own_addresses[0]));
            } else if (!known.neighbour.empty() && facts.taken_by.empty()) {
                problem(host, "address",
                        address + " is answered by another machine already (" + known.neighbour +
                            "); choose a free one, outside of what DHCP gives out");
            }
        }
    }

    void look_at_programs() {
        const HostFacts* first = nullptr;
        for (std::size_t i = 0; i < testbed_.hosts.size(); ++i) {
            const Host& host = testbed_.hosts[i];
            if (!seen_[i].facts) continue;
            const HostFacts& facts = *seen_[i].facts;
            if (facts.version != own_version_) {
                problem(host, "version",
                        "its programs are " + facts.version + ", and this one is " + own_version_ +
                            "; make them alike: romano testbed install HOSTS");
            }
            if (host.role == HostRole::robots) continue;
            if (!facts.does_broker_run) {
                problem(host, "programs",
                        "romano-broker-member does not run there: " + facts.broker_version +
                            "; install the packages that it needs: experiments/TESTBED.md");
                continue;
            }
            if (first != nullptr && first->architecture == facts.architecture &&
                first->broker_digest != facts.broker_digest) {
                problem(host, "version",
                        "its broker is another than that of the hosts before; make them alike: "
                        "romano testbed install HOSTS");
            }
            if (first == nullptr) first = &facts;
        }
    }

    void look_at_settings() {
        const Host* first = nullptr;
        for (const Host& host : testbed_.hosts) {
            if (host.role == HostRole::robots) continue;
            if (first == nullptr) first = &host;
            const std::string here = settings_of(host);
            const std::string there = settings_of(*first);
            if (here == there) continue;
            problem(host, "settings",
                    "its brokers get `" + here + "` and those of " + first->name + " `" + there +
                        "`, which must be the same: set them once, above the hosts");
        }
    }

    /// Those that must be the same, as they are given.
    static std::string settings_of(const Host& host) {
        std::string text;
        bool is_value = false;
        for (const std::string& option : host.broker_options) {
            if (option.starts_with("--")) {
                is_value =
                    std::ranges::count(alike, std::string_view{option}.substr(0, option.find('=')));
            }
            if (!is_value) continue;
            if (!text.empty()) text += " ";
            text += option;
        }
        return text;
    }

    void look_at_multicast() {
        for (std::size_t to = 0; to < testbed_.hosts.size(); ++to) {
            const Host& listener = testbed_.hosts[to];
            if (listener.role == HostRole::robots || !is_heard_of(to)) continue;
            if (!seen_[to].multicast_trouble.empty()) {
                problem(listener, "multicast",
                        "it cannot multicast on `" + listener.interface +
                            "`: " + seen_[to].multicast_trouble);
                continue;
            }
            for (std::size_t from = 0; from < testbed_.hosts.size(); ++from) {
                if (from != to && testbed_.hosts[from].role == HostRole::brokers &&
                    is_heard_of(from) && seen_[from].multicast_trouble.empty()) {
                    compare(listener, seen_[to], testbed_.hosts[from], seen_[from]);
                }
            }
        }
    }

    [[nodiscard]] bool is_heard_of(std::size_t number) const {
        return seen_[number].facts && seen_[number].facts->is_up;
    }

    void compare(const Host& listener, const HostSeen& heard, const Host& speaker,
                 const HostSeen& said) {
        const auto found = heard.heard.find(speaker.name);
        if (found == heard.heard.end()) {
            problem(listener, "multicast",
                    "it does not hear the multicast of " + speaker.name + " on `" +
                        listener.interface +
                        "`; put both into one network, and let its switch or access point pass "
                        "multicast (IGMP snooping needs a querier)");
        } else if (found->second < said.longest_octets) {
            problem(listener, "mtu",
                    "it hears short datagrams of " + speaker.name + " and none of " +
                        std::to_string(said.facts->mtu_octets) +
                        " octets; give both interfaces one MTU that the network carries");
        }
    }

    const Testbed& testbed_;
    const std::vector<HostSeen>& seen_;
    const std::string& own_version_;
    std::vector<HostFinding> findings_;
};

}  // namespace

std::vector<HostFinding> findings_of(const Testbed& testbed, const std::vector<HostSeen>& seen,
                                     const std::string& own_version) {
    return Doctor{testbed, seen, own_version}.look();
}

bool has_problem(const std::vector<HostFinding>& findings) {
    return std::ranges::any_of(findings, [](const HostFinding& each) { return each.is_problem; });
}

std::string to_text(const std::vector<HostFinding>& findings) {
    std::string text;
    for (const HostFinding& each : findings) {
        text += each.host + ": " + (each.is_problem ? "" : "(warning) ") + each.sentence + "\n";
    }
    return text;
}

nlohmann::json to_json(const Testbed& testbed, const std::vector<HostSeen>& seen,
                       const std::vector<HostFinding>& findings) {
    nlohmann::json hosts = nlohmann::json::array();
    for (std::size_t i = 0; i < testbed.hosts.size(); ++i) {
        nlohmann::json host = {{"name", testbed.hosts[i].name}, {"ssh", testbed.hosts[i].ssh}};
        if (seen[i].facts) host["facts"] = *seen[i].facts;
        if (seen[i].clock_offset_s) {
            host["clock_offset_s"] = *seen[i].clock_offset_s;
            host["clock_uncertainty_s"] = seen[i].clock_uncertainty_s;
        }
        host["hears_multicast_octets"] = seen[i].heard;
        hosts.push_back(host);
    }
    nlohmann::json list = nlohmann::json::array();
    for (const HostFinding& each : findings) {
        list.push_back({{"host", each.host},
                        {"about", each.about},
                        {"severity", each.is_problem ? "problem" : "warning"},
                        {"sentence", each.sentence}});
    }
    return {{"hosts", hosts}, {"findings", list}};
}

}  // namespace romano::experiments
