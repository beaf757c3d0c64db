// The topic ids of one client: MQTT-SN 1.2 section 7.3 (a table per client), and G14 to G16.
//
// Ids count upward from 1 and are never given twice within a session; one name has one id.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "broker/core/session_image.h"
#include "romano/mqttsn/types.h"

namespace romano::broker {

class TopicRegistry {
public:
    struct Topic {
        std::string name;      // empty in a gap that an adopted image left
        bool known = false;    // to the client: from REGACK, SUBACK or an accepted REGISTER
        bool refused = false;  // the client answered REGISTER with a refusal (G16)
    };

    /// The id of `name`, or no_topic_id.
    [[nodiscard]] mqttsn::TopicId find(std::string_view name) const;

    /// The topic of a valid id, or null.
    [[nodiscard]] Topic* at(mqttsn::TopicId id) {
        const std::size_t index = static_cast<std::size_t>(id) - 1;  // id 0 becomes huge
        return index < topics_.size() && !topics_[index].name.empty() ? &topics_[index] : nullptr;
    }

    /// The client does, from REGACK, SUBACK or an accepted REGISTER.
    [[nodiscard]] bool knows(mqttsn::TopicId id) const {
        const std::size_t index = static_cast<std::size_t>(id) - 1;
        return index < topics_.size() && topics_[index].known;
    }

    /// Gives a new name the next id; no_topic_id when all ids are used up.
    mqttsn::TopicId add(std::string_view name);

    /// After a kept session is connected anew (G14).
    void forget_known() {
        for (Topic& topic : topics_) topic.known = topic.refused = false;
    }

    /// A new subscription asks for names that were refused too (G16).
    void ask_again() {
        if (!std::exchange(has_refused_, false)) return;
        for (Topic& topic : topics_) topic.refused = false;
    }
    void refuse(mqttsn::TopicId id) {
        topics_[static_cast<std::size_t>(id) - 1].refused = true;
        has_refused_ = true;
    }

    [[nodiscard]] std::size_t size() const { return topics_.size(); }
    [[nodiscard]] std::vector<TopicBinding> bindings() const;
    void restore(std::span<const TopicBinding> bindings);

private:
    static constexpr std::size_t most_topics = 0xFFFE;
    static constexpr std::size_t scanned_topics = 8;  // up to here a scan is as quick as a table

    void index_from(std::size_t first);

    bool has_refused_ = false;
    std::vector<Topic> topics_;         // id - 1 is the index
    std::vector<std::uint16_t> slots_;  // open addressing by name: ids, 0 is free
};

}  // namespace romano::broker
