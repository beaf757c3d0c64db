// Which peer is home to which client, by client id and by address. Kept from the events of their
// logs. While two peers say so, as after a heal, the one that said so last counts; when that one
// takes it back, the other is left. What the dead said stays until an heir says that it is home.
#pragma once

#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "broker/core/mirror.h"
#include "overlay/cluster/messages.h"

namespace romano::cluster {

struct Home {
    broker::ClientId client_id;
    BrokerId broker;
};

class Homes {
public:
    void on_event(BrokerId peer, const broker::LogEvent& event);
    /// Replaces all that is known of the peer.
    void reset(BrokerId peer, const broker::Mirror& sessions);
    void forget(BrokerId peer);
    void forget(BrokerId peer, const broker::ClientId& client);

    [[nodiscard]] std::optional<Home> of(const broker::ClientId& client) const;
    [[nodiscard]] std::optional<Home> at(const broker::ClientAddress& address) const;

private:
    struct Claim {
        BrokerId broker;
        broker::ClientAddress address;
    };
    using Claims = std::vector<Claim>;  // one a peer, the newest last; never empty

    void put(BrokerId peer, const broker::SessionHeader& header);
    void take_back(BrokerId peer, const broker::ClientId& client, Claims& claims);

    std::unordered_map<broker::ClientId, Claims> by_client_;
    std::unordered_map<broker::ClientAddress, broker::ClientId, broker::ClientAddressHash>
        by_address_;
};

}  // namespace romano::cluster
