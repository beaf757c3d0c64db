// The identities of the newest messages that came over the uplink, at whichever broker: what comes
// again is known. Bounded: the oldest is forgotten.
#pragma once

#include <cstddef>
#include <deque>
#include <string>
#include <unordered_set>

namespace romano::uplink {

class SeenIdentities {
public:
    static constexpr std::size_t most = 4096;

    /// False when it was known.
    bool add(const std::string& identity) {
        if (!known_.insert(identity).second) return false;
        order_.push_back(identity);
        if (order_.size() > most) {
            known_.erase(order_.front());
            order_.pop_front();
        }
        return true;
    }
    [[nodiscard]] bool contains(const std::string& identity) const {
        return known_.contains(identity);
    }

private:
    std::unordered_set<std::string> known_;
    std::deque<std::string> order_;
};

}  // namespace romano::uplink
