// How much a client can hold; fixed when compiling, so that a device needs no heap.
#pragma once

#include <cstddef>

namespace romano::client {

struct HostLimits {
    static constexpr std::size_t datagram_octets = 2048;  // the largest that it sends
    static constexpr std::size_t queue_octets = 8192;     // operations that wait; see operations.h
    static constexpr std::size_t topics = 64;             // names with a normal topic id
    static constexpr std::size_t name_octets = 2048;      // of all these names together
    static constexpr std::size_t unreleased = 16;         // QoS 2 received, PUBREL outstanding
};

/// About 1.2 KB for a client and its output.
struct DeviceLimits {
    static constexpr std::size_t datagram_octets = 256;
    static constexpr std::size_t queue_octets = 320;
    static constexpr std::size_t topics = 12;
    static constexpr std::size_t name_octets = 192;
    static constexpr std::size_t unreleased = 4;
};

/// A client can listen to its broker's cell (mqttsn/cell.h).
#ifndef ROMANO_WITHOUT_CELL
inline constexpr bool hears_cells = true;
#else  // for the smallest devices, in all files alike: some 250 octets of flash less
inline constexpr bool hears_cells = false;
#endif

/// What an answer or a ping needs beside the largest datagram in one Output.
inline constexpr std::size_t small_datagrams_octets = 32;

}  // namespace romano::client
