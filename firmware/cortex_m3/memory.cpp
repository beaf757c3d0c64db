// The functions of a C library that a compiler or std::string_view calls by itself, small instead
// of fast.

#include <cstddef>
#include <cstdint>

extern "C" {

// -fno-tree-loop-distribute-patterns keeps the compiler from making them call themselves.

[[gnu::used]] void* memmove(void* to, const void* from, std::size_t size) {
    auto* out = static_cast<std::uint8_t*>(to);
    const auto* in = static_cast<const std::uint8_t*>(from);
    if (out < in) {
        while (size-- != 0) *out++ = *in++;
    } else {
        while (size-- != 0) out[size] = in[size];
    }
    return to;
}

[[gnu::used, gnu::alias("memmove")]] void* memcpy(void* to, const void* from, std::size_t size);

[[gnu::used]] void* memset(void* to, int value, std::size_t size) {
    auto* out = static_cast<std::uint8_t*>(to);
    while (size-- != 0) *out++ = static_cast<std::uint8_t>(value);
    return to;
}

[[gnu::used]] int memcmp(const void* a, const void* b, std::size_t size) {
    const auto* left = static_cast<const std::uint8_t*>(a);
    const auto* right = static_cast<const std::uint8_t*>(b);
    for (; size != 0; --size, ++left, ++right) {
        if (*left != *right) return *left - *right;
    }
    return 0;
}

[[gnu::used]] void* memchr(const void* in, int value, std::size_t size) {
    const auto* at = static_cast<const std::uint8_t*>(in);
    for (; size != 0; --size, ++at) {
        if (*at == static_cast<std::uint8_t>(value)) return const_cast<std::uint8_t*>(at);
    }
    return nullptr;
}

}  // extern "C"
