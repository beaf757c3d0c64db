#include "experiments/testbed/host/network_cut.h"

#include <algorithm>
#include <boost/asio/ip/address.hpp>
#include <sstream>

#include "experiments/process/program.h"

namespace romano::experiments {
namespace {

constexpr const char* cut_table = "netdev romano_testbed_cut";

/// nft has its place where only root looks, which ssh's PATH leaves out.
ProgramEnd nft(const std::string& rules) {
    return run_program(
        "/bin/sh", {"-c", "PATH=$PATH:/usr/sbin:/sbin; printf '%s' \"$0\" | nft -f - 2>&1", rules});
}

bool is_port(const std::string& text) {
    return !text.empty() && text.size() <= 5 &&
           std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; });
}

}  // namespace

SshPath parse_ssh_connection(const std::string& text) {
    std::istringstream words(text);
    SshPath path;
    words >> path.client >> path.client_port >> path.server >> path.server_port;
    boost::system::error_code no_client, no_server;
    const auto client = boost::asio::ip::make_address(path.client, no_client);
    const auto server = boost::asio::ip::make_address(path.server, no_server);
    if (!words || no_client || no_server || client.is_v6() != server.is_v6() ||
        !is_port(path.client_port) || !is_port(path.server_port)) {
        return {};
    }
    return path;
}

std::string cut_rules(const std::string& interface, const SshPath& ssh) {
    std::string in;
    std::string out;
    if (!ssh.client.empty()) {
        const bool is_v6 = ssh.client.find(':') != std::string::npos;
        const std::string family = is_v6 ? "ip6" : "ip";
        // All of ssh: whoever has to help a machine that was left cut off must reach it.
        in = "  " + family + " daddr " + ssh.server + " tcp dport " + ssh.server_port + " accept\n";
        out =
            "  " + family + " saddr " + ssh.server + " tcp sport " + ssh.server_port + " accept\n";
        if (is_v6) {
            in += "  icmpv6 type { nd-neighbor-solicit, nd-neighbor-advert } ip6 saddr " +
                  ssh.client + " accept\n";
            out += "  icmpv6 type { nd-neighbor-solicit, nd-neighbor-advert } ip6 daddr " +
                   ssh.client + " accept\n";
        } else {
            in += "  arp daddr ip " + ssh.server + " accept\n";
            out += "  arp saddr ip " + ssh.server + " accept\n";
        }
    }
    const std::string hook = " device \"" + interface + "\" priority -500; policy drop;\n";
    return std::string{"table "} + cut_table + "\ndelete table " + cut_table + "\ntable " +
           cut_table + " {\n chain in {\n  type filter hook ingress" + hook + in +
           " }\n chain out {\n  type filter hook egress" + hook + out + " }\n}\n";
}

bool can_cut() {
    return nft("list tables").ok();
}

std::string cut_off(const std::string& interface, const SshPath& ssh) {
    const ProgramEnd end = nft(cut_rules(interface, ssh));
    if (end.ok()) return {};
    return end.exit_code == 127 ? "there is no nft here: sudo apt install nftables"
                                : "nft: " + end.output.substr(0, end.output.find('\n'));
}

void mend_network() {
    (void)nft(std::string{"table "} + cut_table + "\ndelete table " + cut_table + "\n");
}

}  // namespace romano::experiments
