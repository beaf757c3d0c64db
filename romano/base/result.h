// A value or the reason why there is none; member names as in C++23's std::expected, so that it
// can be swapped later. For small error types on paths without exceptions.
#pragma once

#include <cassert>
#include <utility>
#include <variant>

namespace romano {

template <typename T, typename E>
class [[nodiscard]] Result {
public:
    constexpr Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}
    constexpr Result(E error) : state_(std::in_place_index<1>, std::move(error)) {}

    [[nodiscard]] constexpr bool has_value() const { return state_.index() == 0; }
    constexpr explicit operator bool() const { return has_value(); }

    constexpr T& value() {
        assert(has_value());
        return *std::get_if<0>(&state_);
    }
    constexpr const T& value() const {
        assert(has_value());
        return *std::get_if<0>(&state_);
    }
    constexpr const E& error() const {
        assert(!has_value());
        return *std::get_if<1>(&state_);
    }

    constexpr T& operator*() { return value(); }
    constexpr const T& operator*() const { return value(); }
    constexpr T* operator->() { return &value(); }
    constexpr const T* operator->() const { return &value(); }

private:
    std::variant<T, E> state_;
};

}  // namespace romano
