// HDLC frames between the robot's controller and its radio, as the authors' firmware speaks them
// (derived from yahdlc): 7E, address FF, control, data, FCS low, FCS high, 7E; 7E and 7D are sent
// as 7D, octet xor 0x20.
//
// Layout only: who numbers, acknowledges and repeats frames is link.h's matter. No heap; bounded;
// any octets in.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "romano/base/bytes.h"

namespace romano::hdlc {

inline constexpr std::size_t max_data = 64;  // octets in a frame, the authors' HDLC_MAX_PKT_SIZE
/// Every octet between the flags stuffed: address, control, data, FCS; and two flags.
inline constexpr std::size_t max_encoded = 2 + 2 * (2 + max_data + 2);

enum class FrameKind : std::uint8_t { data, ack, nack };

struct Frame {
    FrameKind kind = FrameKind::data;
    std::uint8_t seq = 0;  // modulo 8; an ACK carries the number of the frame that it acknowledges
    Bytes data;            // empty unless kind is data
};

/// CRC-16/X-25: reflected polynomial 0x8408, start 0xFFFF, complemented. "123456789" gives 0x906E.
[[nodiscard]] std::uint16_t fcs16(Bytes octets);

/// Writes the whole frame, flags included, to the front of `out`. Returns its size; 0 when the data
/// is longer than max_data or `out` is too small.
[[nodiscard]] std::size_t encode(const Frame& frame, MutableBytes out);

struct FrameCounters {
    std::uint32_t frames = 0;
    std::uint32_t bad_fcs = 0;
    std::uint32_t too_long = 0;   // more octets than a frame may have before the closing flag
    std::uint32_t too_short = 0;  // fewer than address, control and FCS
    std::uint32_t bad_control = 0;
};

/// Finds frames in a stream of octets. What is no frame is dropped and counted; the next flag
/// begins anew.
class FrameDecoder {
public:
    /// The frame that `octet` completes, if it does. Its data is valid until the next call.
    [[nodiscard]] std::optional<Frame> on_octet(std::uint8_t octet);
    [[nodiscard]] const FrameCounters& counters() const { return counters_; }

private:
    [[nodiscard]] std::optional<Frame> close();

    std::array<std::uint8_t, 2 + max_data + 2> octets_{};
    std::size_t size_ = 0;
    bool inside_ = false;    // a flag was seen
    bool escaped_ = false;   // the last octet was 7D
    bool overflow_ = false;  // the frame is too long; skip to its end
    FrameCounters counters_;
};

}  // namespace romano::hdlc
