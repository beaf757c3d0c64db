// Which peers have a subscriber for a topic: QoS 0 publishes go to these only. Kept from the
// events of their logs; what a session wanted until then its mirror knows.
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
    /// The next event of a peer's log, before its mirror applies it.
    void on_event(const broker::Mirror& sessions, const broker::LogEvent& event);
    /// Replaces all that is known of the mirror's broker.
    void reset(const broker::Mirror& sessions);
    /// Forgets what its sessions want: of many, some in each turn.
    void forget(BrokerId peer);
    void on_turn();
    /// What the session wants.
    void add(BrokerId peer, const broker::SessionImage& session);
    void remove(BrokerId peer, const broker::SessionImage& session);

    [[nodiscard]] bool wants(std::string_view topic) const { return tree_.matches(topic); }
    /// Sorted, each once.
    [[nodiscard]] std::vector<BrokerId> interested_in(std::string_view topic) const;

private:
    void add(BrokerId peer, const std::string& filter);
    void remove(BrokerId peer, const std::string& filter);

    broker::TopicTree<BrokerId, std::uint32_t> tree_;  // with the number of the peer's subscribers
    std::set<BrokerId> peers_;                         // that are in it, or were
    std::map<BrokerId, std::size_t> forgotten_;        // of those: filters to be looked at
};

}  // namespace romano::cluster
