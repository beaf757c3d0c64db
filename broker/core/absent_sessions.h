// Kept sessions (CleanSession 0) whose clients are away: disconnected, lost, or without a place
// since another client was heard there. By the IP address that they had: whoever leaves many
// behind, under ever new ids or ports, is the first to lose some, and only his own.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "broker/core/session.h"
#include "romano/base/endpoint.h"
#include "romano/base/time.h"

namespace romano::broker {

class AbsentSessions {
public:
    void add(const Session& session, Instant since) {
        const Endpoint host = host_of(session);
        Absent& absent = by_host_[host];
        const std::size_t before = absent.size();
        absent.emplace(since, session.number);
        recount(host, before, absent.size());
    }
    /// As it was added, if it was.
    void remove(const Session& session, Instant since) {
        const auto found = by_host_.find(host_of(session));
        if (found == by_host_.end()) return;
        auto& [host, absent] = *found;
        const std::size_t before = absent.size();
        absent.erase({since, session.number});
        recount(host, before, absent.size());
        if (absent.empty()) by_host_.erase(found);
    }

    /// Of all that had the IP address of this one.
    [[nodiscard]] std::size_t count_beside(const Session& session) const {
        const auto found = by_host_.find(host_of(session));
        return found == by_host_.end() ? 0 : found->second.size();
    }
    /// The one of them that is away for longest.
    [[nodiscard]] std::optional<SessionNumber> first_beside(const Session& session) const {
        const auto found = by_host_.find(host_of(session));
        if (found == by_host_.end()) return std::nullopt;
        return found->second.begin()->second;
    }
    /// The one that is away for longest of the IP address that has most; none when no address has
    /// two.
    [[nodiscard]] std::optional<SessionNumber> first_of_most() const {
        if (by_count_.empty() || by_count_.rbegin()->first < 2) return std::nullopt;
        return by_host_.at(by_count_.rbegin()->second).begin()->second;
    }

private:
    using Absent = std::set<std::pair<Instant, SessionNumber>>;

    static Endpoint host_of(const Session& session) {
        Endpoint host = session.header.address.endpoint;
        host.port = 0;
        return host;
    }
    void recount(const Endpoint& host, std::size_t before, std::size_t now) {
        by_count_.erase({before, host});
        if (now > 0) by_count_.emplace(now, host);
    }

    std::map<Endpoint, Absent> by_host_;
    std::set<std::pair<std::size_t, Endpoint>> by_count_;
};

}  // namespace romano::broker
