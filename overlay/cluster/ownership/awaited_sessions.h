// While many sessions are adopted in pieces, those come first for which somebody waits: the client
// speaks, or a message was published for it. A client that subscribes with a wildcard is taken to
// want every message. Each topic is looked up once, however many want it.
#pragma once

#include <set>
#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "broker/core/session_image.h"

namespace romano::cluster {

class AwaitedSessions {
public:
    /// The session is still to be adopted. Messages that were published since clear() count.
    void list(const broker::SessionImage& session);
    void on_client(const broker::ClientId& client) { awaited_.insert(client); }
    void on_publish(std::string_view topic);
    /// Takes `most` clients at most, and leaves the others for the next call.
    [[nodiscard]] std::vector<broker::ClientId> take(std::size_t most);
    [[nodiscard]] bool has_any() const { return !awaited_.empty(); }
    void clear() { *this = {}; }

private:
    using Clients = std::vector<broker::ClientId>;

    std::unordered_map<std::string, Clients> of_topic_;
    Clients of_any_;
    std::unordered_set<std::string> topics_;  // of what was published
    std::set<broker::ClientId> awaited_;
};

}  // namespace romano::cluster
