// What waits for one client, in order: the messages behind the one that is in flight.
//
// A vector with a moving front: a session that receives steadily allocates nothing, an empty one
// takes three words. QoS 0 messages wait here too while the client sleeps or must learn a topic id
// first; they are not part of the session's image.
#pragma once

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <vector>

#include "broker/core/session_image.h"

namespace romano::broker {

class DeliveryQueue {
public:
    [[nodiscard]] bool empty() const { return front_ == items_.size(); }
    [[nodiscard]] std::size_t size() const { return items_.size() - front_; }
    /// How many of QoS 0 there are.
    [[nodiscard]] std::size_t unlogged() const { return unlogged_; }

    [[nodiscard]] Delivery& front() {
        assert(!empty());
        return items_[front_];
    }
    [[nodiscard]] auto begin() const {
        return items_.begin() + static_cast<std::ptrdiff_t>(front_);
    }
    [[nodiscard]] auto end() const { return items_.end(); }

    void push(Delivery delivery) {
        if (is_unlogged(delivery)) ++unlogged_;
        items_.push_back(std::move(delivery));
    }

    void pop() {
        assert(!empty());
        if (is_unlogged(items_[front_])) --unlogged_;
        items_[front_++].message = {};
        if (front_ == items_.size()) {
            items_.clear();
            front_ = 0;
        } else if (front_ >= 64 && front_ * 2 >= items_.size()) {
            items_.erase(items_.begin(), items_.begin() + static_cast<std::ptrdiff_t>(front_));
            front_ = 0;
        }
    }

    /// False when the message is not here.
    bool erase(const LogPosition& position) {
        const auto found = std::find_if(begin(), end(), [&](const Delivery& delivery) {
            return delivery.position == position;
        });
        if (found == end()) return false;
        if (found == begin()) {
            pop();
        } else {
            if (is_unlogged(*found)) --unlogged_;
            items_.erase(found);
        }
        return true;
    }

    /// Drops the oldest message of QoS 0, but never the front when that is in use; false when there
    /// is none.
    bool drop_oldest_unlogged(bool front_in_use) {
        if (unlogged_ == 0) return false;
        std::size_t at = front_ + (front_in_use ? 1 : 0);
        while (at < items_.size() && !is_unlogged(items_[at])) ++at;
        if (at == items_.size()) return false;
        items_.erase(items_.begin() + static_cast<std::ptrdiff_t>(at));
        --unlogged_;
        return true;
    }

    void clear() { *this = DeliveryQueue{}; }

private:
    static bool is_unlogged(const Delivery& delivery) {
        return delivery.qos == mqttsn::Qos::at_most_once;
    }

    std::vector<Delivery> items_;
    std::size_t front_ = 0;
    std::size_t unlogged_ = 0;
};

}  // namespace romano::broker
