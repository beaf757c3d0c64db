// IEEE 802.15.4 with 6LoWPAN, as ns-3 models it, behind a boundary without ns-3's types. Used like
// a core: the owner says the time, asks for the next wakeup, and is called back while time goes on.
//
// ns-3 has one simulator in a process, so there is one Channel at a time. Its headers are C++17.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

namespace romano::lowpan {

inline constexpr unsigned first_channel = 11;  // at 2.4 GHz, IEEE 802.15.4-2011 section 8.1.2
inline constexpr unsigned last_channel = 26;
inline constexpr std::size_t most_robots = 1000;  // with 16-bit addresses there could be more

/// A border router with its robots: one PAN.
struct CellPlan {
    unsigned channel = last_channel;
    std::size_t robots = 0;
    bool all_talk = false;  // robots to each other, too
};

struct Device {
    std::size_t cell = 0;
    std::size_t number = 0;  // 0: the border router; robots from 1
    friend bool operator==(const Device& a, const Device& b) {
        return a.cell == b.cell && a.number == b.number;
    }
    friend bool operator<(const Device& a, const Device& b) {
        return a.cell != b.cell ? a.cell < b.cell : a.number < b.number;
    }
};

struct Counters {
    std::uint64_t frames = 0;      // begun on the air, repetitions and acknowledgements too
    std::uint64_t air_octets = 0;  // of them, from the MAC header to the FCS
    std::uint64_t given_up = 0;    // after the last repetition, or with the channel never free
    std::uint64_t duplicates = 0;  // repeated though received: their acknowledgement was lost
};

/// What a radio sent.
struct Air {
    std::uint64_t frames = 0;
    std::uint64_t octets = 0;  // from the MAC header to the FCS
};
/// How long that takes: 32 us an octet, and six octets of preamble, SFD and length before each
/// frame (IEEE 802.15.4-2011 section 10.1).
[[nodiscard]] std::int64_t air_time_ns(const Air& air);

class Channel {
public:
    struct Owner {
        /// The strength with which a frame sent now by `from` comes to `to`.
        std::function<double(Device from, Device to)> dbm;
        std::function<void(Device at, Device from, const std::vector<std::uint8_t>& datagram)>
            received;
        /// The device has sent its datagram, or has given it up, and can take the next one.
        std::function<void(Device)> ready;
    };

    /// Channels exist, and no cell has more than most_robots.
    Channel(const std::vector<CellPlan>& cells, double transmit_dbm, double noise_dbm,
            std::uint64_t seed, Owner owner);
    ~Channel();
    Channel(const Channel&) = delete;
    Channel& operator=(const Channel&) = delete;

    /// Between a border router and a robot of its cell, or two robots of a cell where all talk. The
    /// device is ready.
    void send(std::int64_t now_ns, Device from, Device to,
              const std::vector<std::uint8_t>& datagram);

    /// From any device to all others of its cell that hear it: once, without acknowledgement.
    void broadcast(std::int64_t now_ns, Device from, const std::vector<std::uint8_t>& datagram);

    void run_until(std::int64_t now_ns);
    [[nodiscard]] std::int64_t next_wakeup_ns() const;  // INT64_MAX: nothing is due
    [[nodiscard]] const Counters& counters() const;
    [[nodiscard]] const Air& sent_by(Device device) const;

private:
    struct Ns3;
    std::unique_ptr<Ns3> ns3_;
};

}  // namespace romano::lowpan
