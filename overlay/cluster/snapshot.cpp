#include "overlay/cluster/snapshot.h"

#include <utility>

namespace romano::cluster {
namespace {

// Parts of a few kilobytes each with the payloads that robots send.
constexpr std::size_t sessions_per_part = 16;
constexpr std::size_t messages_per_part = 64;

/// Fills parts one after the other; a part leaves when it is full.
class Parts {
public:
    Parts(LogPosition as_of, BrokerId to, Outbox& out) : to_(to), out_(out) { part_.as_of = as_of; }

    void add(broker::SessionImage image) {
        if (part_.sessions.size() == sessions_per_part) next();
        part_.sessions.push_back(std::move(image));
    }
    void add_retained(const MessagePtr& message) {
        if (part_.retained.size() == messages_per_part) next();
        part_.retained.push_back(message);
    }
    void add_publish(const MessagePtr& message) {
        if (part_.publishes.size() == messages_per_part) next();
        part_.publishes.push_back(message);
    }
    void finish(std::vector<LogPosition> cursors) {
        part_.cursors = std::move(cursors);
        part_.last = true;
        next();
    }

private:
    void next() {
        SnapshotPart following{.as_of = part_.as_of, .part = part_.part + 1};
        out_.push_back({to_, std::exchange(part_, std::move(following))});
    }

    BrokerId to_;
    Outbox& out_;
    SnapshotPart part_;
};

}  // namespace

void send_snapshot(const broker::BrokerCore& broker, const Logs& logs, BrokerId to, Outbox& out) {
    Parts parts({logs.own.id(), logs.own.last()}, to, out);
    for (auto& image : broker.images()) parts.add(std::move(image));
    for (const auto& message : broker.retained()) parts.add_retained(message);
    for (const auto& message : logs.own.history().publishes_after(0)) parts.add_publish(message);
    parts.finish(broker.cursors());
}

}  // namespace romano::cluster
