// The normal topic ids that a client knows, with their names: MQTT-SN 1.2
// sections 5.3.11, 6.5, 6.9.
//
// Ids come from REGACK, SUBACK and the broker's REGISTER. The table lives in storage that its owner
// gives it at birth; a full table refuses new names. Looks up by walking: a client knows
// a few dozen names.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "romano/mqttsn/types.h"

namespace romano::client {

class TopicTable {
public:
    struct Entry {
        mqttsn::TopicId id;
        std::uint16_t name_size;
    };

    TopicTable(std::span<Entry> entries, std::span<char> names)
        : entries_(entries), names_(names) {}

    /// no_topic_id when the name has none.
    [[nodiscard]] mqttsn::TopicId id_of(std::string_view name) const;

    /// Empty when the id is unknown; no name is empty.
    [[nodiscard]] std::string_view name_of(mqttsn::TopicId id) const;

    /// True when put() of `name` under an id that is not in the table will succeed.
    [[nodiscard]] bool has_room_for(std::string_view name) const;

    /// A new name for a known id replaces the old one, which means nothing any more; so the id is
    /// unknown when there is no room for the new one. A name may have several ids while there is
    /// room. False when full; the other names stay.
    [[nodiscard]] bool put(mqttsn::TopicId id, std::string_view name);

    void forget(mqttsn::TopicId id);
    void clear();

private:
    std::span<Entry> entries_;  // the first size_; their names stand in names_ in the same order
    std::span<char> names_;
    std::size_t size_ = 0;
    std::size_t names_size_ = 0;
};

}  // namespace romano::client
