// Whether this broker may be the one that was cut off, and what it does not say then.
//
// It lost more members of its view by silence than it has left: the others may well live, have
// taken its clients over and sent them what was in flight here. Said once more from here, in the
// moment in which the way is open again, that would be a QoS 2 message delivered twice; and what
// comes from here calls clients away from a broker that lives (ARP). So nothing is repeated
// (PUBLISH with DUP, PUBREL) to a client that was not heard since, nor is a QoS 2 message sent for
// the first time to one whose address was taken over: its heir among the others may have sent it,
// and what is sent into a cut waits in the kernel and leaves when that is over. When a client is
// heard again, what it says waits, for the way may be open again for the other brokers too, and
// then it is theirs. They come within a moment, or else it is served: in a part of the network that
// is cut off indeed, clients are served. Whoever was heard while the others were missing already
// does not wait: what cut us off from them left its way open.
//
// Back in a view with the others, or in its first one, it says nothing and lets clients wait until
// it hears all of them, for a moment at most: whoever took over may be one that it does not hear
// yet, while the logs of the others bring messages that its clients have had from there; and to one
// that has just started again, its own clients would be strangers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <set>

#include "overlay/cluster/messages.h"
#include "overlay/cluster/speaking/way.h"
#include "romano/base/bytes.h"
#include "romano/base/time.h"

namespace romano::cluster {

class CutOff {
public:
    using Judgement = std::function<bool(const broker::LogId& member)>;

    /// `others_come_within`: the transport finds processes that it lost in that time. A client that
    /// says nothing but PINGREQ must not seem to be lost meanwhile.
    explicit CutOff(Duration others_come_within) : others_come_within_(others_come_within) {}

    /// To be told of the view after each input. `has_ended(member)`: that process is known to be
    /// gone; it did not just fall silent. `is_heard(member)`: it is alive. True when the doubt is
    /// over now: what was withheld may be said.
    bool on_view(Instant now, const View& view, const Judgement& has_ended,
                 const Judgement& is_heard);
    /// The client was heard while the others were missing, and no view says so yet.
    void on_heard_in_doubt(Instant now, const Way& client);
    /// Whether what the client says now has to wait. To be asked again for what waits.
    [[nodiscard]] bool must_wait(Instant now, const Way& client);
    enum class Address : std::uint8_t { own, taken_over };
    /// `from`: whose service address it would leave from.
    [[nodiscard]] bool withholds(Instant now, Address from, const Way& client,
                                 Bytes datagram) const;
    /// It may talk to the others, and was not heard since: to be silent here is no sign of its
    /// loss.
    [[nodiscard]] bool may_be_elsewhere(const Way& client) const {
        return is_in_doubt() && !served_from_.contains(client) && !near_.contains(client);
    }
    [[nodiscard]] bool is_possible() const { return missing_.size() > members_.size(); }
    /// It is possible, or was a moment ago.
    [[nodiscard]] bool is_in_doubt() const { return is_possible() || !awaited_.empty(); }

private:
    void see(Instant now, const View& view, const Judgement& has_ended);

    static constexpr std::size_t heard_most = 100'000;  // beyond: the rest is served at once

    Duration others_come_within_;
    ViewNumber seen_;
    std::set<broker::LogId> members_;  // of the view that was seen last
    std::set<broker::LogId> missing_;  // that fell silent in it or before
    std::set<broker::LogId> awaited_;  // in the view that took us in, and not heard yet
    Instant awaited_until_{};
    std::map<Way, Instant> served_from_;  // the clients that were heard since
    std::set<Way> near_;                  // those that were heard in doubt
    Instant near_until_{};                // that doubt is long past, when it came to nothing
};

}  // namespace romano::cluster
