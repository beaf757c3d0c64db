// The sessions that are homed here, by number, by client id and by where their clients were heard.
//
// Here alone it is decided whose a datagram is that names nobody (G7): of the client that was heard
// last at that client address and service address. It keeps its place when it is left behind: what
// comes from there then is a stranger's, and not of another client with the same address. Nobody is
// heard there who is known to have talked to another service address, unless he is the only one at
// his address: then he roams.
//
// A number is used again after its session is gone, so numbers stay small and index tables.
#pragma once

#include <cstddef>
#include <memory>
#include <set>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "broker/core/absent_sessions.h"
#include "broker/core/pointer_table.h"
#include "broker/core/session.h"

namespace romano::broker {

class SessionTable {
public:
    /// A new session; there must be none of that id.
    Session& create(std::string_view client_id);
    void erase(Session& session);

    [[nodiscard]] Session* find(std::string_view client_id) const;
    /// The one that was heard last there; it may be left behind.
    [[nodiscard]] Session* find(const Origin& place) const;
    /// The one that is connected from that address, to whichever service address; null when there
    /// is none, or there are several and nobody can tell who speaks.
    [[nodiscard]] Session* only_one_at(const ClientAddress& address) const;
    [[nodiscard]] bool has_connected_at(const ClientAddress& address) const;
    [[nodiscard]] Session* at(SessionNumber number) const {
        return number < slots_.size() ? slots_[number].get() : nullptr;
    }

    /// What comes from there is this session's from now on; that of its previous owner, who is
    /// returned, no more: it is displaced.
    Session* map(Session& session, const Origin& place, Instant now);
    /// Nothing leads to it any more.
    void unmap(Session& session);
    /// So, too, when another client was heard later where it was: one that is connected as far as
    /// anybody knows has no place then.
    void displace(Session& session, Instant now);

    /// Takes note that a session was left behind: a clean one for departed_first(), a kept one for
    /// absent().
    void depart(Session& session, Instant now);
    /// Its client is there again.
    void come_back(Session& session);
    /// The clean session that was left behind longest ago, or null.
    [[nodiscard]] Session* departed_first() const;
    /// The clean one that is connected as far as anybody knows, but whose address another client
    /// has had for longest; or null.
    [[nodiscard]] Session* displaced_first() const;
    /// The kept ones that were left behind or displaced, but for the one that the owner reads.
    [[nodiscard]] const AbsentSessions& absent() const { return absent_; }

    [[nodiscard]] std::size_t size() const { return by_id_.size(); }
    /// All numbers are below it.
    [[nodiscard]] std::size_t numbers() const { return slots_.size(); }
    /// Not left behind.
    [[nodiscard]] std::size_t connected() const { return size() - departed_count_; }
    /// In the order of their client ids, whatever was there before.
    [[nodiscard]] std::vector<Session*> by_client_id() const;

    /// By number: the same order in every replay.
    template <typename Visitor>
    void visit(Visitor&& visit_one) const {
        for (const auto& slot : slots_) {
            if (slot != nullptr) visit_one(*slot);
        }
    }

private:
    void be_absent(const Session& session, Instant since);
    void find_again(Session& session);

    std::vector<std::unique_ptr<Session>> slots_;
    std::vector<SessionNumber> free_;
    std::unordered_map<std::string_view, Session*> by_id_;  // views of the headers' client ids
    PointerTable<Session> by_address_;
    std::set<std::pair<Instant, SessionNumber>> departed_;   // the clean ones
    std::size_t departed_count_ = 0;                         // all
    std::set<std::pair<Instant, SessionNumber>> displaced_;  // the clean ones
    AbsentSessions absent_;
};

}  // namespace romano::broker
