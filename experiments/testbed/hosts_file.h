// hosts.toml: the machines of a testbed, how ssh reaches them, and what runs on each. The keys and
// their defaults are explained in experiments/TESTBED.md.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "experiments/sweep/setting_error.h"

namespace romano::experiments {

enum class HostRole : std::uint8_t {
    brokers,  // has service addresses, with a broker at each
    robots,   // runs simulated robots between `testbed start` and `stop`; sweeps leave it alone
};

struct Host {
    std::string name;  // in this file, in sentences and in names of files
    std::string ssh;   // destination, as people give it to ssh
    std::vector<std::string> ssh_options;
    HostRole role = HostRole::brokers;
    std::string interface = "eth0";  // on which the brokers speak to each other and to clients
    /// IP addresses that clients know: they move from machine to machine, and are no machine's own.
    std::vector<std::string> addresses;
    std::string folder = "/opt/romano-testbed";  // there: programs that are no packages, and logs
    std::vector<std::string> broker_options;     // the testbed's, then its own
    std::uint32_t robots = 1;
};

struct Testbed {
    std::vector<Host> hosts;
    std::uint16_t port = 1883;  // of `testbed start`; sweeps have their own
    std::uint32_t domain = 7;   // of `testbed start`; sweeps have their own
    std::vector<std::string> robot_options;
    std::string text;  // the file, as read

    /// Of all machines, in the order of the file.
    [[nodiscard]] std::vector<std::string> addresses() const;
};

/// Throws SettingError.
[[nodiscard]] Testbed parse_hosts(std::string_view text, const std::string& file_name);
[[nodiscard]] Testbed read_hosts(const std::filesystem::path& file);

}  // namespace romano::experiments
