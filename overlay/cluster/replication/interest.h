// Which peers have a subscriber for a topic: QoS 0 publishes go to these only. Kept from the
// events of their logs.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "broker/core/mirror.h"
#include "broker/core/topic_tree.h"
#include "overlay/cluster/messages.h"

namespace romano::cluster {

class Interest {
public:
    void on_event(BrokerId peer, const broker::LogEvent& event);
    /// Replaces all that is known of the peer.
    void reset(BrokerId peer, const broker::Mirror& sessions);
    void forget(BrokerId peer);
    /// A session as it is now.
    void put(BrokerId peer, const broker::SessionImage& image);
    void remove_session(BrokerId peer, const broker::ClientId& client);

    [[nodiscard]] bool wants(std::string_view topic) const;
    /// Sorted, each once.
    [[nodiscard]] std::vector<BrokerId> interested_in(std::string_view topic) const;

private:
    using Filters = std::set<std::string>;

    void add(BrokerId peer, const broker::ClientId& client, const std::string& filter);
    void remove(BrokerId peer, const std::string& filter);

    broker::TopicTree<BrokerId, std::uint32_t> tree_;  // with the number of the peer's subscribers
    std::map<BrokerId, std::map<broker::ClientId, Filters>> filters_;
};

}  // namespace romano::cluster
