// A vector whose capacity is part of its type: for devices without a heap.
#pragma once

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <span>

namespace romano {

template <typename T, std::size_t Capacity>
class FixedVector {
public:
    constexpr FixedVector() = default;

    /// False, and nothing changed, when full.
    [[nodiscard]] constexpr bool push_back(const T& item) {
        if (size_ == Capacity) return false;
        items_[size_++] = item;
        return true;
    }

    /// A new item at the end, or nullptr when full.
    [[nodiscard]] constexpr T* add() {
        if (size_ == Capacity) return nullptr;
        items_[size_] = {};
        return &items_[size_++];
    }

    /// False, and nothing changed, when `items` do not fit.
    [[nodiscard]] constexpr bool assign(std::span<const T> items) {
        if (items.size() > Capacity) return false;
        std::copy(items.begin(), items.end(), items_.begin());
        size_ = items.size();
        return true;
    }

    /// Removes the item at `index`; those behind it move up.
    constexpr void erase_at(std::size_t index) {
        assert(index < size_);
        std::move(items_.begin() + static_cast<std::ptrdiff_t>(index) + 1,
                  items_.begin() + static_cast<std::ptrdiff_t>(size_),
                  items_.begin() + static_cast<std::ptrdiff_t>(index));
        --size_;
    }

    /// Removes the items for which `is_unwanted` holds; those behind them move up.
    template <typename Predicate>
    constexpr void erase_if(Predicate is_unwanted) {
        std::size_t kept = 0;
        for (std::size_t i = 0; i < size_; ++i) {
            if (is_unwanted(items_[i])) continue;
            if (kept != i) items_[kept] = items_[i];
            ++kept;
        }
        size_ = kept;
    }

    constexpr void clear() { size_ = 0; }
    [[nodiscard]] constexpr std::size_t size() const { return size_; }
    [[nodiscard]] constexpr bool empty() const { return size_ == 0; }
    [[nodiscard]] constexpr bool full() const { return size_ == Capacity; }
    [[nodiscard]] static constexpr std::size_t capacity() { return Capacity; }

    constexpr T& operator[](std::size_t index) {
        assert(index < size_);
        return items_[index];
    }
    constexpr const T& operator[](std::size_t index) const {
        assert(index < size_);
        return items_[index];
    }
    constexpr T* begin() { return items_.data(); }
    constexpr T* end() { return items_.data() + size_; }
    constexpr const T* begin() const { return items_.data(); }
    constexpr const T* end() const { return items_.data() + size_; }
    constexpr const T* data() const { return items_.data(); }
    constexpr operator std::span<const T>() const { return {items_.data(), size_}; }

private:
    std::array<T, Capacity> items_{};
    std::size_t size_ = 0;
};

}  // namespace romano
