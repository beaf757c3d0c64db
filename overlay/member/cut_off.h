// Whether this broker may be the one that was cut off, and what it does not say then.
//
// It lost more members of its view by silence than it has left: the others may well live, have
// taken its clients over and sent them what was in flight here. Said once more from here, in the
// moment in which the way is open again, that would be a QoS 2 message delivered twice; and what
// comes from here calls clients away from a broker that lives (ARP). So nothing is repeated
// (PUBLISH with DUP, PUBREL) to a client that was not heard since. What is new goes out as ever: in
// a part of the network that is cut off indeed, clients are served.
#pragma once

#include <cstddef>
#include <functional>
#include <set>

#include "overlay/cluster/messages.h"
#include "romano/base/bytes.h"
#include "romano/base/endpoint.h"

namespace romano::overlay {

class CutOff {
public:
    /// `has_ended(member)`: that process is known to be gone; it did not just fall silent.
    using HasEnded = std::function<bool(const broker::LogId& member)>;

    /// To be told of the view after each input. True when it has become impossible now: what was
    /// withheld may be said.
    bool on_view(const cluster::View& view, const HasEnded& has_ended);
    void on_heard(const Endpoint& client);
    [[nodiscard]] bool withholds(const Endpoint& client, Bytes datagram) const;
    [[nodiscard]] bool is_possible() const { return missing_.size() > present_; }

private:
    static constexpr std::size_t heard_most = 100'000;  // beyond: the rest counts as not heard

    cluster::ViewNumber seen_;
    std::set<broker::LogId> members_;  // of the view that was seen last
    std::set<broker::LogId> missing_;  // that fell silent in it or before
    std::size_t present_ = 0;
    std::set<Endpoint> heard_;
};

}  // namespace romano::overlay
