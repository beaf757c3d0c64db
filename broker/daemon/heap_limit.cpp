#include "broker/daemon/heap_limit.h"

#include <malloc.h>
#include <spdlog/spdlog.h>

#include <atomic>
#include <cstdlib>
#include <new>

namespace {

std::atomic<std::size_t> in_use{0};  // DDS has threads of its own

/// Null when there is no memory.
void* take(std::size_t size) noexcept {
    void* block = std::malloc(size == 0 ? 1 : size);
    in_use.fetch_add(malloc_usable_size(block), std::memory_order_relaxed);
    return block;
}
void* take(std::size_t size, std::align_val_t alignment) noexcept {
    const auto align = static_cast<std::size_t>(alignment);
    void* block = std::aligned_alloc(align, (size + align - 1) / align * align);
    in_use.fetch_add(malloc_usable_size(block), std::memory_order_relaxed);
    return block;
}

void* or_throw(void* block) {
    if (block == nullptr) throw std::bad_alloc{};
    return block;
}

void give_back(void* block) noexcept {
    in_use.fetch_sub(malloc_usable_size(block), std::memory_order_relaxed);
    std::free(block);
}

}  // namespace

// The forms that the others of the standard library are made of; those that do not throw are made
// of the first ones too, but not under AddressSanitizer, which has its own.
void* operator new(std::size_t size) {
    return or_throw(take(size));
}
void* operator new(std::size_t size, std::align_val_t alignment) {
    return or_throw(take(size, alignment));
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
    return take(size);
}
void* operator new(std::size_t size, std::align_val_t alignment, const std::nothrow_t&) noexcept {
    return take(size, alignment);
}
void operator delete(void* block) noexcept {
    give_back(block);
}
void operator delete(void* block, std::size_t) noexcept {
    give_back(block);
}
void operator delete(void* block, std::align_val_t) noexcept {
    give_back(block);
}
void operator delete(void* block, std::size_t, std::align_val_t) noexcept {
    give_back(block);
}

namespace romano::daemon {

std::size_t HeapLimit::octets_in_use() {
    return in_use.load(std::memory_order_relaxed);
}

bool HeapLimit::is_reached() {
    const bool before = reached_;
    const std::size_t used = octets_in_use();
    reached_ = used >= (before ? most_ - most_ / 16 : most_);
    if (reached_ && !before) {
        spdlog::warn(
            "{} MiB of memory are in use, as many as --max-memory-mb allows; until some are free "
            "clients that bring what stays hear \"congestion\"",
            used >> 20U);
    } else if (before && !reached_) {
        spdlog::info("memory is free again: {} MiB are in use", used >> 20U);
    }
    return reached_;
}

void HeapLimit::add_metrics(metrics::Page& page) const {
    page.gauge("romano_heap_octets", "Memory that sessions, messages and all else take.",
               static_cast<double>(octets_in_use()));
    page.gauge("romano_heap_limit_octets", "The most that they may take (--max-memory-mb).",
               static_cast<double>(most_));
}

}  // namespace romano::daemon
