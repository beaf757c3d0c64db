// Which peer is home to which client, by client id and by where the client was heard. Kept from the
// events of their logs. While two peers say so, as after a heal, the one that said so last counts;
// when that one takes it back, the other is left. What the dead said stays until an heir says that
// it is home.
//
// Of two clients that were heard at one client address and service address the later one is there
// (broker/core/session_table.h has the same rule for the own clients).
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
    /// A session of the peer as it is now.
    void put(BrokerId peer, const broker::SessionHeader& header);
    void forget(BrokerId peer);
    void forget(BrokerId peer, const broker::ClientId& client);

    [[nodiscard]] std::optional<Home> of(const broker::ClientId& client) const;
    /// Of the client that was heard last there.
    [[nodiscard]] std::optional<Home> at(const broker::Origin& place) const;
    /// Of the one that is connected from that address, to whichever service address; none when
    /// there are several.
    [[nodiscard]] std::optional<Home> only_one_at(const broker::ClientAddress& address) const;
    /// Another client than this one is connected from its address.
    [[nodiscard]] bool share_address_with(const broker::SessionHeader& client) const;

private:
    struct Claim {
        BrokerId broker;
        broker::Origin place;
    };
    using Claims = std::vector<Claim>;  // one a peer, the newest last; never empty

    /// Who was heard last at an address and a service address.
    struct Heard {
        Endpoint via;
        broker::ClientId client_id;
        broker::HybridTime at;
        bool is_connected;
    };

    void take_back(BrokerId peer, const broker::ClientId& client, Claims& claims);
    void lose(BrokerId peer, const broker::ClientId& client);
    void leave(const broker::ClientId& client, const broker::Origin& place);

    std::unordered_map<broker::ClientId, Claims> by_client_;
    /// One for each service address, and so never many.
    std::unordered_map<broker::ClientAddress, std::vector<Heard>, broker::ClientAddressHash>
        by_address_;
};

}  // namespace romano::cluster
