// A reliable line between two stations over frames: stop-and-wait, each direction by itself,
// numbers modulo 8.
//
// Interoperates with the authors' firmware: a data frame is repeated without limit until its ACK
// (or NACK, which counts as one) arrives; the receiver acknowledges the expected frame and its
// predecessor, delivers only the expected one, and leaves every other number unanswered. The owner
// moves octets and time; no heap.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "firmware/hdlc/frame.h"
#include "romano/base/bytes.h"
#include "romano/base/time.h"

namespace romano::hdlc {

/// Pause before a frame is repeated: the radio's setting. The controller uses 50 ms.
inline constexpr Duration default_repeat_after = to_duration(std::chrono::milliseconds{100});

class Link {
public:
    explicit Link(Duration repeat_after = default_repeat_after) : repeat_after_(repeat_after) {}

    /// True when the last data was acknowledged and the next may be sent.
    [[nodiscard]] bool is_idle() const { return !waiting_; }

    /// Takes data to send; the encoded frame is `line_out()` afterwards. False, and nothing taken,
    /// when the link is not idle or the data is longer than max_data.
    [[nodiscard]] bool send(Instant now, Bytes data);

    /// One octet from the line. When it completes new data, that data, valid until the next call;
    /// an answer that has to go out is `line_out()` afterwards.
    [[nodiscard]] std::optional<Bytes> on_octet(Instant now, std::uint8_t octet);

    /// Repeats what was not acknowledged in time.
    void on_tick(Instant now);
    [[nodiscard]] Instant next_wakeup() const { return waiting_ ? repeat_at_ : never; }

    /// Octets to write to the line since the last clear_line_out().
    [[nodiscard]] Bytes line_out() const { return Bytes{out_}.first(out_size_); }
    void clear_line_out() { out_size_ = 0; }

    [[nodiscard]] const FrameCounters& frame_counters() const { return decoder_.counters(); }
    [[nodiscard]] std::uint32_t repeats() const { return repeats_; }

private:
    static constexpr std::size_t max_ack = 10;  // an acknowledgement, all octets stuffed

    void write_data(Instant now);
    void write_ack(std::uint8_t seq);

    Duration repeat_after_;
    FrameDecoder decoder_;
    std::array<std::uint8_t, max_data> data_{};
    std::size_t data_size_ = 0;
    std::uint8_t send_seq_ = 0;    // of the frame in flight, or of the next one
    std::uint8_t expect_seq_ = 0;  // of the next new frame from the peer
    bool waiting_ = false;
    Instant repeat_at_ = never;
    std::uint32_t repeats_ = 0;
    std::array<std::uint8_t, max_encoded + 4 * max_ack> out_{};
    std::size_t out_size_ = 0;
};

}  // namespace romano::hdlc
