#include "overlay/dds/packing.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <utility>
#include <variant>

namespace romano::dds {
namespace {

// What fits UDP's largest datagram travels in one piece on a loopback, and in few elsewhere.
constexpr std::size_t most_octets = 48'000;
constexpr std::size_t small_event_octets = 64;

std::size_t size_of(const broker::MessagePtr& message) {
    return message ? message->topic.size() + message->payload.size() : 0;
}

std::size_t size_of(const broker::LogEventPtr& event) {
    std::size_t size = small_event_octets;
    if (const auto* published = std::get_if<broker::Published>(&*event)) {
        size += size_of(published->message) + published->routes.size() * small_event_octets;
    } else if (const auto* routed = std::get_if<broker::Routed>(&*event)) {
        size += routed->routes.size() * small_event_octets;
    } else if (const auto* cursor = std::get_if<broker::Cursor>(&*event)) {
        size += cursor->through.size() * small_event_octets;
    } else if (const auto* put = std::get_if<broker::SessionPut>(&*event)) {
        const broker::SessionImage& image = put->image;
        size += (image.subscriptions.size() + image.topics.size()) * small_event_octets;
        for (const auto& delivery : image.deliveries) {
            size += small_event_octets + size_of(delivery.message);
        }
    }
    return size;
}

template <typename Items>
std::size_t size_of_all(const Items& items) {
    std::size_t size = 0;
    for (const auto& item : items) size += size_of(item);
    return size;
}

template <typename Items>
void move_behind(Items& to, Items& from) {
    to.insert(to.end(), std::make_move_iterator(from.begin()), std::make_move_iterator(from.end()));
}

// One overload a kind that can be joined: true when `late` now stands in `early`.
bool join(cluster::LogBatch& early, cluster::LogBatch& late) {
    if (late.log != early.log || late.first_seq != early.first_seq + early.events.size()) {
        return false;
    }
    if (size_of_all(early.events) + size_of_all(late.events) > most_octets) return false;
    move_behind(early.events, late.events);
    early.awaited |= late.awaited;
    return true;
}

bool join(cluster::ForwardBatch& early, cluster::ForwardBatch& late) {
    if (size_of_all(early.messages) + size_of_all(late.messages) > most_octets) return false;
    move_behind(early.messages, late.messages);
    return true;
}

bool join(cluster::LogAck& early, cluster::LogAck& late) {
    if (late.through.log != early.through.log || late.by != early.by) return false;
    early.through.seq = std::max(early.through.seq, late.through.seq);
    return true;
}

/// Joins `late` to the last message of its kind to the same receiver, if that can take it.
template <typename Kind>
bool join_to_last(std::vector<overlay::Outgoing>& packed, overlay::Outgoing& late) {
    for (auto early = packed.rbegin(); early != packed.rend(); ++early) {
        if (early->to != late.to) continue;
        if (auto* message = std::get_if<Kind>(&early->message)) {
            return join(*message, std::get<Kind>(late.message));
        }
    }
    return false;
}

bool join_to_last(std::vector<overlay::Outgoing>& packed, overlay::Outgoing& late) {
    if (std::holds_alternative<cluster::LogBatch>(late.message)) {
        return join_to_last<cluster::LogBatch>(packed, late);
    }
    if (std::holds_alternative<cluster::ForwardBatch>(late.message)) {
        return join_to_last<cluster::ForwardBatch>(packed, late);
    }
    if (std::holds_alternative<cluster::LogAck>(late.message)) {
        return join_to_last<cluster::LogAck>(packed, late);
    }
    return false;
}

}  // namespace

void pack(std::vector<overlay::Outgoing>& messages) {
    if (messages.size() < 2) return;
    std::vector<overlay::Outgoing> packed;
    packed.reserve(messages.size());
    for (overlay::Outgoing& message : messages) {
        if (!join_to_last(packed, message)) packed.push_back(std::move(message));
    }
    messages.swap(packed);
}

}  // namespace romano::dds
