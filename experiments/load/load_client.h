// One MQTT-SN client core of a load, in memory that all clients of the load share: among ten
// thousand of them most of the work on a datagram is waiting for memory, so each has as much as the
// plan needs, and what every message touches lies together.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "experiments/load/load_plan.h"
#include "romano/client/client.h"
#include "romano/mqttsn/cell.h"

namespace romano::experiments {

/// How large the room of a client is, and what stands where in it.
struct ClientLayout {
    explicit ClientLayout(const LoadPlan& plan)
        : topics(plan.most_topics_of_a_client() + 1),  // and the cell's name
          name_octets((topics - 1) * plan.topic_name(plan.topics).size() +
                      mqttsn::cell_topic.size()),
          // Operations that wait behind the one that the broker has not answered yet.
          queue_octets((sizeof(client::Operation) + plan.topic_name(plan.topics).size() +
                        plan.payload_octets) *
                       (plan.in_flight / plan.publishers + 8)) {}

    static constexpr std::size_t unreleased = 16;
    static constexpr std::size_t line = 64;

    [[nodiscard]] std::size_t octets() const {
        const std::size_t sum = topics * sizeof(client::TopicTable::Entry) +
                                unreleased * sizeof(mqttsn::MsgId) + name_octets + queue_octets;
        return (sum + line - 1) / line * line;
    }

    std::size_t topics;
    std::size_t name_octets;
    std::size_t queue_octets;
};

class LoadClient : public client::ClientCore {
public:
    /// `room` has layout.octets() and belongs to this client alone.
    LoadClient(const LoadPlan& plan, std::string client_id, const client::Timing& timing,
               std::uint32_t number, const ClientLayout& layout, std::uint8_t* room)
        : ClientCore(cut(layout, room), timing, number),
          id(std::move(client_id)),
          to_subscribe(plan.heard_by(number)),
          to_register(plan.published_by(number)) {}

    void prefetch() const {
        const auto* octets = reinterpret_cast<const std::uint8_t*>(this);
        for (std::size_t at = 0; at < sizeof(ClientCore); at += ClientLayout::line) {
            __builtin_prefetch(octets + at);
        }
    }

    const std::string id;
    std::vector<std::uint32_t> to_subscribe;
    std::vector<std::uint32_t> to_register;
    std::size_t set_up = 0;  // of both, in order
    bool joined = false;
    int congested = 0;  // times that the broker had no room, while joining

private:
    static Storage cut(const ClientLayout& layout, std::uint8_t* at) {
        Storage storage{};
        storage.topics = take<client::TopicTable::Entry>(at, layout.topics);
        storage.unreleased = take<mqttsn::MsgId>(at, ClientLayout::unreleased);
        storage.names = take<char>(at, layout.name_octets);
        storage.queue = take<std::uint8_t>(at, layout.queue_octets);
        storage.datagram_octets = mqttsn::max_datagram;
        return storage;
    }

    template <typename T>
    static std::span<T> take(std::uint8_t*& at, std::size_t count) {
        T* first = reinterpret_cast<T*>(at);
        std::uninitialized_value_construct_n(first, count);
        at += count * sizeof(T);
        return {first, count};
    }
};

}  // namespace romano::experiments
