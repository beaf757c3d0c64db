// An application message on its way: published once, shared by all queues that it waits in.
//
// Immutable after publication and counted by reference within one thread, so that a fan-out copies
// pointers. `position` names the message in the cluster: the place of its Published event. A
// message of QoS 0 that is not retained is in no log; its position's seq is 0.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "broker/core/hybrid_time.h"
#include "broker/core/log_position.h"
#include "romano/mqttsn/types.h"

namespace romano::broker {

struct Message {
    std::string topic;
    std::vector<std::uint8_t> payload;
    mqttsn::Qos qos = mqttsn::Qos::at_most_once;  // as published; QoS -1 is stored as 0
    bool retain = false;                          // as published
    LogPosition position;
    HybridTime published_at;
    std::string origin = {};  // names what came over the uplink; empty: a client published it
};

/// Shared ownership of an immutable Message; not thread-safe, by design (one broker, one thread).
class MessagePtr {
public:
    MessagePtr() = default;
    explicit MessagePtr(Message message) : node_(new Node{std::move(message), 1}) {}
    MessagePtr(const MessagePtr& other) : node_(other.node_) {
        if (node_ != nullptr) ++node_->references;
    }
    MessagePtr(MessagePtr&& other) noexcept : node_(std::exchange(other.node_, nullptr)) {}
    MessagePtr& operator=(MessagePtr other) noexcept {
        std::swap(node_, other.node_);
        return *this;
    }
    ~MessagePtr() {
        if (node_ != nullptr && --node_->references == 0) delete node_;
    }

    explicit operator bool() const { return node_ != nullptr; }
    const Message& operator*() const { return node_->message; }
    const Message* operator->() const { return &node_->message; }
    friend bool operator==(const MessagePtr& a, const MessagePtr& b) { return a.node_ == b.node_; }

private:
    struct Node {
        Message message;
        std::uint32_t references;
    };
    Node* node_ = nullptr;
};

}  // namespace romano::broker
