#include "romano/client/topic_table.h"

#include <algorithm>

#include "romano/client/limits.h"

namespace romano::client {

mqttsn::TopicId TopicTable::id_of(std::string_view name) const {
    const char* at = names_.data();
    for (const Entry& entry : entries_.first(size_)) {
        if (std::string_view{at, entry.name_size} == name) return entry.id;
        at += entry.name_size;
    }
    return mqttsn::no_topic_id;
}

std::string_view TopicTable::name_of(mqttsn::TopicId id) const {
    const char* at = names_.data();
    for (const Entry& entry : entries_.first(size_)) {
        if (entry.id == id) return {at, entry.name_size};
        at += entry.name_size;
    }
    return {};
}

bool TopicTable::has_room_for(std::string_view name) const {
    return size_ < entries_.size() && name.size() <= names_.size() - names_size_;
}

bool TopicTable::make_room_for(std::string_view name) {
    const Entry* entry = entries_.data();
    while (!has_room_for(name)) {
        if (entry == entries_.data() + size_) {
            // A broker that gives one name several ids must not fill the table with it.
            forget(id_of(name));
            return has_room_for(name);
        }
        if (entry->use == Use::to_publish) {
            forget(entry->id);  // the next one moves up
        } else {
            ++entry;
        }
    }
    return true;
}

bool TopicTable::put(mqttsn::TopicId id, std::string_view name, Use use) {
    if (name_of(id) == name) {
        if (hears_cells && use == Use::to_receive) receive(id);
        return true;
    }
    forget(id);
    if (!make_room_for(name)) return false;
    std::copy(name.begin(), name.end(), names_.data() + names_size_);
    names_size_ += name.size();
    entries_[size_++] = {id, static_cast<std::uint16_t>(name.size()), use};
    return true;
}

/// From now on messages come under that id, too.
void TopicTable::receive(mqttsn::TopicId id) {
    for (Entry& entry : entries_.first(size_)) {
        if (entry.id == id) entry.use = Use::to_receive;
    }
}

void TopicTable::forget(mqttsn::TopicId id) {
    std::size_t name_at = 0;
    for (std::size_t i = 0; i < size_; ++i) {
        const std::size_t name_size = entries_[i].name_size;
        if (entries_[i].id == id) {
            char* names = names_.data();
            std::copy(names + name_at + name_size, names + names_size_, names + name_at);
            std::copy(entries_.data() + i + 1, entries_.data() + size_, entries_.data() + i);
            names_size_ -= name_size;
            --size_;
            return;
        }
        name_at += name_size;
    }
}

void TopicTable::clear() {
    size_ = 0;
    names_size_ = 0;
}

}  // namespace romano::client
