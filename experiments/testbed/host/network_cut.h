// Cuts this machine off from its network, all but ssh, through which it is told to: an nftables
// table on the interface that lets nothing in and nothing out, ARP included. The cable
// stays; the machine's own settings stay; whoever asks for the machine's own address over ARP is
// answered, so that ssh does not lose it.
#pragma once

#include <string>
#include <vector>

namespace romano::experiments {

struct SshPath {
    std::string client;  // IP address
    std::string client_port;
    std::string server;
    std::string server_port;
};
/// As sshd's variable SSH_CONNECTION has it. All empty when it is none.
[[nodiscard]] SshPath parse_ssh_connection(const std::string& text);

/// What nft is told.
[[nodiscard]] std::string cut_rules(const std::string& interface, const SshPath& ssh);

[[nodiscard]] bool can_cut();
/// What nft said when it could not; else empty.
[[nodiscard]] std::string cut_off(const std::string& interface, const SshPath& ssh);
/// Whatever a session of before has left.
void mend_network();

}  // namespace romano::experiments
