// The sessions that are homed here, by number, by client id and by address.
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

#include "broker/core/pointer_table.h"
#include "broker/core/session.h"

namespace romano::broker {

class SessionTable {
public:
    /// A new session; there must be none of that id.
    Session& create(std::string_view client_id);
    void erase(Session& session);

    [[nodiscard]] Session* find(std::string_view client_id) const;
    [[nodiscard]] Session* find(const ClientAddress& address) const;
    [[nodiscard]] Session* at(SessionNumber number) const {
        return number < slots_.size() ? slots_[number].get() : nullptr;
    }

    /// The address leads to this session from now on; its previous owner, who is returned, becomes
    /// unreachable (G7).
    Session* map(Session& session, const ClientAddress& address, Instant now);
    /// No address leads to it any more.
    void unmap(Session& session);

    /// Takes note that a session was left behind; a clean one for departed_first().
    void depart(Session& session, Instant now);
    void come_back(Session& session);
    /// The clean session that was left behind longest ago, or null.
    [[nodiscard]] Session* departed_first() const;
    /// The clean one that is connected as far as anybody knows, but whose address another client
    /// has had for longest; or null.
    [[nodiscard]] Session* displaced_first() const;

    [[nodiscard]] std::size_t size() const { return by_id_.size(); }
    /// Not left behind.
    [[nodiscard]] std::size_t connected() const { return size() - departed_count_; }
    /// In the order of their client ids: for all that reaches the wire.
    [[nodiscard]] std::vector<Session*> by_client_id() const;

    template <typename Visitor>
    void visit(Visitor&& visit_one) const {
        for (const auto& slot : slots_) {
            if (slot != nullptr) visit_one(*slot);
        }
    }

private:
    void find_again(Session& session);

    std::vector<std::unique_ptr<Session>> slots_;
    std::vector<SessionNumber> free_;
    std::unordered_map<std::string_view, Session*> by_id_;  // views of the headers' client ids
    PointerTable<Session> by_address_;
    std::set<std::pair<Instant, SessionNumber>> departed_;  // the clean ones
    std::size_t departed_count_ = 0;                        // all
    std::set<std::pair<Instant, SessionNumber>> displaced_;
};

}  // namespace romano::broker
