// The normal topic ids that a client knows, with their names: MQTT-SN 1.2
// sections 5.3.11, 6.5, 6.9.
//
// Ids come from REGACK, SUBACK and the broker's REGISTER. The table lives in storage that its owner
// gives it at birth. When it is full, names that were learned to publish on give way to new ones,
// the oldest first: they are registered anew when they are needed again. The others stay, for
// messages come under their ids, and without room a new name is refused. Looks up by walking: a
// client knows a few dozen names.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "romano/mqttsn/types.h"

namespace romano::client {

class TopicTable {
public:
    enum class Use : bool { to_receive, to_publish };
    struct Entry {
        mqttsn::TopicId id;
        std::uint16_t name_size;
        Use use;
    };

    TopicTable(std::span<Entry> entries, std::span<char> names)
        : entries_(entries), names_(names) {}

    /// no_topic_id when the name has none.
    [[nodiscard]] mqttsn::TopicId id_of(std::string_view name) const;

    /// Empty when the id is unknown; no name is empty.
    [[nodiscard]] std::string_view name_of(mqttsn::TopicId id) const;

    /// True when put() of `name` under an id that is not in the table will succeed.
    [[nodiscard]] bool make_room_for(std::string_view name);

    /// A new name for a known id replaces the old one, which means nothing any more; so the id is
    /// unknown when there is no room for the new one. A name may have several ids while there is
    /// room. False when full.
    [[nodiscard]] bool put(mqttsn::TopicId id, std::string_view name, Use use);

    void forget(mqttsn::TopicId id);
    void clear();

private:
    void receive(mqttsn::TopicId id);
    [[nodiscard]] bool has_room_for(std::string_view name) const;

    std::span<Entry> entries_;  // the first size_; their names stand in names_ in the same order
    std::span<char> names_;
    std::size_t size_ = 0;
    std::size_t names_size_ = 0;
};

}  // namespace romano::client
