// A handle of Cyclone DDS that is deleted with its owner, and the error that making one may give.
#pragma once

#include <dds/dds.h>

#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

namespace romano::dds {

/// Only while starting up: a domain, topic, reader or writer that cannot be made.
class DdsError : public std::runtime_error {
public:
    explicit DdsError(const std::string& sentence) : std::runtime_error(sentence) {}
    DdsError(const std::string& what, dds_return_t code)
        : std::runtime_error(what + ": " + dds_strretcode(code)) {}
};

class Entity {
public:
    Entity() = default;
    /// Throws DdsError when `handle` is an error code.
    Entity(dds_entity_t handle, const std::string& what) : handle_(handle) {
        if (handle < 0) throw DdsError(what, handle);
    }
    Entity(Entity&& other) noexcept : handle_(std::exchange(other.handle_, 0)) {}
    Entity& operator=(Entity&& other) noexcept {
        std::swap(handle_, other.handle_);
        return *this;
    }
    ~Entity() {
        if (handle_ > 0) dds_delete(handle_);
    }

    [[nodiscard]] dds_entity_t handle() const { return handle_; }

private:
    dds_entity_t handle_ = 0;
};

}  // namespace romano::dds
