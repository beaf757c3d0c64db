// Which peer is home to which client, by client id and by address. Kept from the events of their
// logs.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <unordered_map>

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

    [[nodiscard]] std::optional<Home> of(const broker::ClientId& client) const;
    [[nodiscard]] std::optional<Home> at(const broker::ClientAddress& address) const;

private:
    void put(BrokerId peer, const broker::SessionHeader& header);
    void erase(BrokerId peer, const broker::ClientId& client);

    struct Entry {
        BrokerId broker;
        broker::ClientAddress address;
    };
    std::unordered_map<broker::ClientId, Entry> by_client_;  // the newest to say so
    std::unordered_map<broker::ClientAddress, broker::ClientId, broker::ClientAddressHash>
        by_address_;
};

}  // namespace romano::cluster
