// A value that is made once and never changes, with as many owners as there are copies of this: a
// copy costs no more than a pointer.
//
// Counted within one thread, by design: a core has one.
#pragma once

#include <concepts>
#include <cstdint>
#include <utility>

namespace romano {

template <typename Value>
class Shared {
public:
    /// Of nothing.
    Shared() = default;
    template <typename From>
    requires std::convertible_to<From, Value> Shared(From&& value)
        : node_(new Node{Value(std::forward<From>(value)), 1}) {}
    Shared(const Shared& other) : node_(other.node_) {
        if (node_ != nullptr) ++node_->owners;
    }
    Shared(Shared&& other) noexcept : node_(std::exchange(other.node_, nullptr)) {}
    Shared& operator=(Shared other) noexcept {
        std::swap(node_, other.node_);
        return *this;
    }
    ~Shared() {
        if (node_ != nullptr && --node_->owners == 0) delete node_;
    }

    explicit operator bool() const { return node_ != nullptr; }
    const Value& operator*() const { return node_->value; }
    const Value* operator->() const { return &node_->value; }
    /// Of one value that was made once.
    friend bool operator==(const Shared& a, const Shared& b) { return a.node_ == b.node_; }

private:
    struct Node {
        Value value;
        std::uint32_t owners;
    };
    Node* node_ = nullptr;
};

}  // namespace romano
