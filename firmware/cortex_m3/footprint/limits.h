// What each of these programs has room for: their sizes are compared.
#pragma once

#include <cstddef>

struct Limits {
    static constexpr std::size_t datagram_octets = 512;
    static constexpr std::size_t queue_octets = 512;
    static constexpr std::size_t topics = 8;
    static constexpr std::size_t name_octets = 128;
    static constexpr std::size_t unreleased = 4;
};
