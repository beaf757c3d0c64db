#include "broker/core/topic_registry.h"

#include <functional>

namespace romano::broker {

using mqttsn::TopicId;

namespace {

std::size_t slot_of(std::string_view name, std::size_t slots) {
    return std::hash<std::string_view>{}(name) & (slots - 1);
}

}  // namespace

TopicId TopicRegistry::find(std::string_view name) const {
    if (slots_.empty()) {
        for (std::size_t i = 0; i < topics_.size(); ++i) {
            if (topics_[i].name == name) return TopicId{static_cast<std::uint16_t>(i + 1)};
        }
        return mqttsn::no_topic_id;
    }
    for (std::size_t slot = slot_of(name, slots_.size());;
         slot = (slot + 1) & (slots_.size() - 1)) {
        const std::uint16_t id = slots_[slot];
        if (id == 0) return mqttsn::no_topic_id;
        if (topics_[id - 1U].name == name) return TopicId{id};
    }
}

TopicId TopicRegistry::add(std::string_view name) {
    if (topics_.size() == most_topics) return mqttsn::no_topic_id;
    topics_.push_back({std::string{name}});
    index_from(topics_.size() - 1);
    return TopicId{static_cast<std::uint16_t>(topics_.size())};
}

void TopicRegistry::index_from(std::size_t first) {
    if (topics_.size() <= scanned_topics) return;
    if (topics_.size() * 2 > slots_.size()) {
        std::size_t slots = 32;
        while (slots < topics_.size() * 3) slots *= 2;
        slots_.assign(slots, 0);
        first = 0;
    }
    for (std::size_t i = first; i < topics_.size(); ++i) {
        std::size_t slot = slot_of(topics_[i].name, slots_.size());
        while (slots_[slot] != 0) slot = (slot + 1) & (slots_.size() - 1);
        slots_[slot] = static_cast<std::uint16_t>(i + 1);
    }
}

std::vector<TopicBinding> TopicRegistry::bindings() const {
    std::vector<TopicBinding> all;
    all.reserve(topics_.size());
    for (std::size_t i = 0; i < topics_.size(); ++i) {
        if (topics_[i].name.empty()) continue;
        all.push_back(
            {TopicId{static_cast<std::uint16_t>(i + 1)}, topics_[i].name, topics_[i].known});
    }
    return all;
}

void TopicRegistry::restore(std::span<const TopicBinding> bindings) {
    topics_.clear();
    slots_.clear();
    for (const TopicBinding& binding : bindings) {
        const auto id = static_cast<std::size_t>(binding.id);
        if (id == 0 || id > most_topics) continue;
        if (topics_.size() < id) topics_.resize(id);
        topics_[id - 1] = {binding.name, binding.known_to_client};
    }
    index_from(0);
}

}  // namespace romano::broker
