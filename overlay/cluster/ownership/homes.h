// Which peer is home to which client, by client id and by where the client was heard. The events of
// the peers' logs tell it. While two peers say so, as after a heal, the one that said so last
// counts; when that one takes it back, the other is left. What the dead said stays until an heir
// says that it is home, and counts only where nobody else says so.
//
// Of two clients that were heard at one client address and service address the later one is there
// (broker/core/session_table.h has the same rule for the own clients).
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <unordered_map>

#include "broker/core/mirror.h"
#include "broker/core/pointer_table.h"
#include "overlay/cluster/messages.h"

namespace romano::cluster {

class Homes {
public:
    void on_event(BrokerId peer, const broker::LogEvent& event);
    /// Replaces all that the peer has said since its last log ended.
    void reset(BrokerId peer, const broker::Mirror& sessions);
    /// A session of the peer as it is now.
    void put(BrokerId peer, const broker::SessionHeader& header);
    /// Its log has ended.
    void on_end(BrokerId peer);
    void forget(BrokerId peer);
    void forget(BrokerId peer, const broker::ClientId& client);
    /// Forgets what the peer's ended log said.
    void forget_ended(BrokerId peer);
    void forget_ended(BrokerId peer, const broker::ClientId& client);

    [[nodiscard]] std::optional<BrokerId> of(const broker::ClientId& client) const;
    /// The client that was heard last there.
    [[nodiscard]] std::optional<broker::ClientId> at(const broker::Origin& place) const;
    /// The one that is connected from that address, to whichever service address; none when
    /// there are several.
    [[nodiscard]] std::optional<broker::ClientId> only_one_at(
        const broker::ClientAddress& address) const;
    /// Another client than this one is connected from its address.
    [[nodiscard]] bool share_address_with(const broker::SessionHeader& client) const;

private:
    /// What a peer says of a client of its own.
    struct Claim {
        BrokerId broker;
        broker::Origin place;
        broker::HybridTime heard_at;  // there, as whoever said so last has it
        std::uint64_t number = 0;     // the newest has the highest
        bool is_connected = false;
        bool is_there = false;  // nobody else was heard later at that place
    };
    using Claims = std::unordered_multimap<broker::ClientId, Claim>;  // one a peer
    using Entry = Claims::value_type;

    template <typename IsOne>
    void erase_claims(BrokerId peer, IsOne&& is_one);
    /// Its number; 0 when the broker's log has ended since.
    [[nodiscard]] std::uint64_t place_in_time(const Claim& claim) const;
    [[nodiscard]] Claims::iterator find(BrokerId peer, const broker::ClientId& client);
    Claims::iterator erase(Claims::iterator entry);
    void lose(BrokerId peer, const broker::ClientId& client);
    /// Decides who is there of all that were heard at its place.
    void settle_place_of(const Entry& newest);
    /// Calls `look(Entry&)` for each claim with that address.
    template <typename Look>
    void visit(const broker::ClientAddress& address, Look&& look) const;

    Claims by_client_;
    broker::PointerTable<Entry> by_address_;
    std::uint64_t claims_heard_ = 0;
    std::map<BrokerId, std::uint64_t> ended_;  // the last claim that was heard before
};

}  // namespace romano::cluster
