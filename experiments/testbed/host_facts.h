// What a machine of a testbed says of itself, before anything runs there.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace romano::experiments {

/// Of an address that clients are to know.
struct AddressFacts {
    std::string address;
    bool is_own = false;         // the machine has it for good
    bool is_in_network = false;  // it lies in a network of the interface
    std::string neighbour;       // hardware address of the machine that answers for it already
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(AddressFacts, address, is_own, is_in_network, neighbour)

struct HostFacts {
    std::string version;         // of romano-host, with its commit
    std::string architecture;    // as uname tells it
    std::string broker_version;  // what romano-broker-member says of itself, or why it does not run
    bool does_broker_run = false;
    std::string broker_digest;       // of the programs' octets
    bool may_add_addresses = false;  // CAP_NET_ADMIN
    bool may_announce = false;       // CAP_NET_RAW
    bool may_cut = false;            // there is nft, which cuts a machine off
    bool has_interface = false;
    bool is_up = false;
    bool can_multicast = false;
    int mtu_octets = 0;
    std::vector<std::string> own_addresses;  // of the interface
    std::vector<AddressFacts> addresses;
    std::string port_user;  // who has the UDP port; empty: nobody
    std::int64_t free_mib = 0;
    std::string taken_by;  // what runs there for a testbed; empty: nothing
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(HostFacts, version, architecture, broker_version,
                                   does_broker_run, broker_digest, may_add_addresses, may_announce,
                                   may_cut, has_interface, is_up, can_multicast, mtu_octets,
                                   own_addresses, addresses, port_user, free_mib, taken_by)

/// What is asked.
struct FactsRequest {
    std::string interface;
    std::vector<std::string> addresses;
    std::uint16_t port = 0;
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(FactsRequest, interface, addresses, port)

}  // namespace romano::experiments
