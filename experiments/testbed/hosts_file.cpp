#include "experiments/testbed/hosts_file.h"

#include <algorithm>
#include <array>
#include <boost/asio/ip/address.hpp>
#include <fstream>
#include <iterator>
#include <set>

#include "experiments/sweep/toml_table.h"

namespace romano::experiments {
namespace {

constexpr std::int64_t most_robots = 1000;
constexpr std::int64_t last_domain = 232;  // Cyclone DDS's ports are 7400 + 250 * domain

/// What the testbed itself tells each broker.
constexpr std::array<std::string_view, 4> own_options = {"--name", "--listen", "--domain",
                                                         "--interface"};

bool is_name(const std::string& text) {
    return !text.empty() && text.size() <= 40 && text.front() != '-' &&
           std::ranges::all_of(text, [](char c) {
               return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-';
           });
}

/// What may stand in a path of a shell and of scp without a second thought.
bool is_plain_folder(const std::string& text) {
    return text.size() > 1 && text.front() == '/' && std::ranges::all_of(text, [](char c) {
               return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                      std::string_view{"/-_."}.find(c) != std::string_view::npos;
           });
}

std::vector<std::string> read_addresses(const TomlTable& table, HostRole role) {
    std::vector<std::string> addresses = table.words("addresses");
    const toml::node* node = table.find("addresses");
    if (role == HostRole::robots && node != nullptr) {
        table.refuse(*node, "addresses", "a host of `role = \"robots\"` serves no address");
    }
    for (std::string& address : addresses) {
        boost::system::error_code none;
        const auto read = boost::asio::ip::make_address(address, none);
        if (none || read.is_unspecified() || read.is_loopback() || read.is_multicast()) {
            table.refuse(*node, "addresses",
                         "`" + address +
                             "` is none; IP addresses of the interface's network are allowed that "
                             "no machine has, such as \"192.168.1.101\"");
        }
        address = read.to_string();
    }
    return addresses;
}

/// `common` has what stands at the top of the file, for all hosts.
Host read_host(const TomlTable& table, const Host& common, const std::string& file,
               std::size_t number) {
    table.allow_only({"name", "ssh", "ssh_options", "role", "interface", "addresses", "folder",
                      "broker_options", "robots"});
    Host host = common;
    host.name = table.word("name", "host" + std::to_string(number));
    if (!is_name(host.name)) {
        table.refuse(*table.find("name"), "name",
                     "up to 40 lower-case letters, digits and - are allowed");
    }
    host.ssh = table.word("ssh", "");
    if (host.ssh.empty()) {
        throw SettingError(file + ": host `" + host.name +
                           "` has no `ssh`; give its destination, such as ssh = "
                           "\"pi@192.168.1.11\"");
    }
    if (host.ssh.front() == '-') {
        table.refuse(*table.find("ssh"), "ssh", "a destination such as \"pi@192.168.1.11\"");
    }
    for (const std::string& option : table.words("ssh_options")) host.ssh_options.push_back(option);
    const std::string role = table.word("role", "brokers");
    if (role != "brokers" && role != "robots") {
        table.refuse(*table.find("role"), "role", "allowed are brokers, robots");
    }
    host.role = role == "robots" ? HostRole::robots : HostRole::brokers;
    host.interface = table.word("interface", common.interface);
    host.folder = table.word("folder", common.folder);
    if (!is_plain_folder(host.folder)) {
        table.refuse(*table.find("folder"), "folder",
                     "a path from / of letters, digits and -_. is allowed");
    }
    host.addresses = read_addresses(table, host.role);
    if (host.role == HostRole::brokers && host.addresses.empty()) {
        throw SettingError(file + ": host `" + host.name +
                           "` has no `addresses`; give one for each of its brokers, such as "
                           "addresses = [\"192.168.1.101\"], or `role = \"robots\"`");
    }
    for (const std::string& option : table.options("broker_options", own_options, "the testbed")) {
        host.broker_options.push_back(option);
    }
    host.robots = static_cast<std::uint32_t>(table.integer("robots", 1, 1, most_robots));
    return host;
}

void refuse_what_stands_twice(const Testbed& testbed, const std::string& file) {
    std::set<std::string> names;
    std::set<std::string> addresses;
    for (const Host& host : testbed.hosts) {
        if (!names.insert(host.name).second) {
            throw SettingError(file + ": two hosts are called `" + host.name +
                               "`; give each a `name` of its own");
        }
        for (const std::string& address : host.addresses) {
            if (addresses.insert(address).second) continue;
            throw SettingError(file + ": the address " + address +
                               " stands there twice; each broker serves one of its own");
        }
    }
}

}  // namespace

std::vector<std::string> Testbed::addresses() const {
    std::vector<std::string> all;
    for (const Host& host : hosts) {
        all.insert(all.end(), host.addresses.begin(), host.addresses.end());
    }
    return all;
}

Testbed parse_hosts(std::string_view text, const std::string& file_name) {
    const toml::table document = parse_toml(text, file_name);
    const TomlTable table{document, file_name, ""};
    table.allow_only({"ssh_options", "interface", "folder", "port", "domain", "broker_options",
                      "robot_options", "hosts"});
    Testbed testbed{.hosts = {}, .robot_options = {}, .text = std::string{text}};
    testbed.port = static_cast<std::uint16_t>(table.integer("port", testbed.port, 1, 65535));
    testbed.domain =
        static_cast<std::uint32_t>(table.integer("domain", testbed.domain, 0, last_domain));
    testbed.robot_options = table.words("robot_options");
    Host common;
    common.ssh_options = table.words("ssh_options");
    common.interface = table.word("interface", common.interface);
    common.folder = table.word("folder", common.folder);
    common.broker_options = table.options("broker_options", own_options, "the testbed");

    const toml::node* hosts = table.find("hosts");
    if (hosts == nullptr) {
        throw SettingError(file_name +
                           ": no host; at least one `[[hosts]]` with `ssh` and `addresses` is "
                           "needed");
    }
    if (!hosts->is_array_of_tables()) {
        table.refuse(*hosts, "hosts", "tables are allowed: [[hosts]], one for each machine");
    }
    for (const toml::node& each : *hosts->as_array()) {
        testbed.hosts.push_back(read_host({*each.as_table(), file_name, "hosts."}, common,
                                          file_name, testbed.hosts.size() + 1));
    }
    refuse_what_stands_twice(testbed, file_name);
    return testbed;
}

Testbed read_hosts(const std::filesystem::path& file) {
    std::ifstream stream(file);
    const std::string text{std::istreambuf_iterator<char>(stream), {}};
    if (!stream || text.empty()) {
        throw SettingError(
            "cannot read the hosts file `" + file.string() + "`: " +
            (std::filesystem::exists(file) ? "it is empty or not readable" : "no such file"));
    }
    return parse_hosts(text, file.filename().string());
}

}  // namespace romano::experiments
