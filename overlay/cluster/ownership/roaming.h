// A client whose session is homed at a peer talks to us: we fetch the session, which takes a round
// trip, and the client's datagrams wait meanwhile. If the home has died, they wait until an heir
// says that it has the session, and we fetch it there. If the home has just let the session go,
// because the client roams faster than a round trip, they wait until the next home says so. If
// nobody says so, because others hear the home and we do not, we adopt the copy that we hold, and
// settlement.h does the rest. For a session that is on its way from here we wait until it arrives
// or comes back. We ask no home with other predefined topics: its client is a stranger here.
//
// We wait for so many clients at a time, and for each so long, longer while its home lives. After
// that we handle the datagram as a stranger's. Time in which this broker stands still does not
// count.
#pragma once

#include <compare>
#include <deque>
#include <map>
#include <optional>

#include "overlay/cluster/agreement/membership.h"
#include "overlay/cluster/effects.h"
#include "overlay/cluster/ownership/arrivals.h"
#include "overlay/cluster/ownership/departures.h"
#include "overlay/cluster/ownership/homes.h"
#include "romano/base/bytes.h"
#include "romano/base/endpoint.h"

namespace romano::cluster {

/// The way of a client's datagrams: where they come from, and to which service address. Two clients
/// may be at one address, but on one way there is one (broker/core/session_table.h).
struct Way {
    Endpoint via;
    Endpoint from;

    friend auto operator<=>(const Way&, const Way&) = default;
};

class Roaming {
public:
    /// `predefined`: the own digest of the predefined topics.
    explicit Roaming(std::uint32_t predefined) : predefined_(predefined) {}

    /// The client of the datagram, when its session is known and not here.
    [[nodiscard]] std::optional<broker::ClientId> client_elsewhere(
        const broker::BrokerCore& own, const Way& way, Bytes datagram, const Homes& homes,
        const Departures& leaving, const Membership& membership) const;
    /// True when the datagram shall wait: we ask for its session.
    bool on_datagram(Effects& effects, const Way& way, Bytes datagram, const Homes& homes,
                     const Departures& leaving, const Membership& membership, const View& view);
    /// We let it go to a peer, or a peer's log says that it is no longer home to the client.
    void on_let_go(const Effects& effects, const broker::SessionHeader& session);
    /// Looks again who is home to those whose sessions are awaited.
    void carry_on(Effects& effects, const Logs& logs, const Homes& homes, const Arrivals& arriving,
                  Departures& departures, const Membership& membership, const View& view);
    void on_standstill(Instant now);
    [[nodiscard]] bool is_fetching(const Way& way) const { return fetching_.contains(way); }
    /// Whose session the datagram is of; none when nobody knows.
    [[nodiscard]] std::optional<broker::ClientId> client_of(const Way& way, Bytes datagram,
                                                            const broker::BrokerCore& own,
                                                            const Homes& homes) const;

private:
    struct Fetching {
        broker::ClientId client;
        Instant since;
        std::optional<BrokerId> asked;  // none: its home cannot answer
        Instant asked_at;
    };

    struct LetGo {
        broker::ClientId client;
        broker::ClientAddress from;
        Instant until;
    };

    /// Who speaks there; none when nobody knows, or two clients share the address.
    [[nodiscard]] std::optional<broker::ClientId> client_at(const broker::Origin& place,
                                                            const broker::BrokerCore& own,
                                                            const Homes& homes) const;
    [[nodiscard]] static Duration patience_with(const Effects& effects, const Fetching& fetching,
                                                const Membership& membership, const View& view);
    static void adopt_copy(Effects& effects, const Logs& logs, const broker::ClientId& client,
                           const Homes& homes, Departures& departures);
    void ask(Effects& effects, const Way& way, Fetching& fetching, const Homes& homes,
             const Membership& membership, const View& view) const;

    [[nodiscard]] bool is_foreign(const broker::ClientId& client, const Homes& homes,
                                  const Membership& membership) const;

    std::uint32_t predefined_;
    std::map<Way, Fetching> fetching_;
    std::deque<LetGo> let_go_;  // in order of time
};

}  // namespace romano::cluster
