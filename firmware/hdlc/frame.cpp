#include "firmware/hdlc/frame.h"

namespace romano::hdlc {

namespace {

constexpr std::uint8_t flag = 0x7E;
constexpr std::uint8_t escape = 0x7D;
constexpr std::uint8_t flip = 0x20;
constexpr std::uint8_t all_stations = 0xFF;

constexpr std::uint16_t fcs_start = 0xFFFF;

constexpr std::uint16_t fcs_step(std::uint16_t fcs, std::uint8_t octet) {
    fcs ^= octet;
    for (int bit = 0; bit < 8; ++bit) {
        const bool low = (fcs & 1U) != 0;
        fcs = static_cast<std::uint16_t>(fcs >> 1U);
        if (low) fcs ^= 0x8408U;
    }
    return fcs;
}

constexpr std::uint8_t control_of(const Frame& frame) {
    const unsigned seq = frame.seq & 7U;
    switch (frame.kind) {
        case FrameKind::ack:
            return static_cast<std::uint8_t>((seq << 5U) | 0x01U);
        case FrameKind::nack:
            return static_cast<std::uint8_t>((seq << 5U) | 0x09U);
        default:
            return static_cast<std::uint8_t>((seq << 1U) | 0x10U);
    }
}

class StuffedWriter {
public:
    explicit StuffedWriter(MutableBytes out) : out_(out) {}
    void raw(std::uint8_t octet) {
        if (size_ < out_.size()) out_[size_] = octet;
        ++size_;
    }
    void stuffed(std::uint8_t octet) {
        if (octet == flag || octet == escape) {
            raw(escape);
            octet ^= flip;
        }
        raw(octet);
    }
    [[nodiscard]] std::size_t finish() const { return size_ <= out_.size() ? size_ : 0; }

private:
    MutableBytes out_;
    std::size_t size_ = 0;
};

}  // namespace

std::uint16_t fcs16(Bytes octets) {
    std::uint16_t fcs = fcs_start;
    for (const std::uint8_t octet : octets) fcs = fcs_step(fcs, octet);
    return static_cast<std::uint16_t>(~fcs);
}

std::size_t encode(const Frame& frame, MutableBytes out) {
    if (frame.data.size() > max_data) return 0;
    StuffedWriter writer(out);
    std::uint16_t fcs = fcs_start;
    const auto covered = [&](std::uint8_t octet) {
        fcs = fcs_step(fcs, octet);
        writer.stuffed(octet);
    };
    writer.raw(flag);
    covered(all_stations);
    covered(control_of(frame));
    for (const std::uint8_t octet : frame.data) covered(octet);
    const auto sum = static_cast<std::uint16_t>(~fcs);
    writer.stuffed(static_cast<std::uint8_t>(sum & 0xFFU));
    writer.stuffed(static_cast<std::uint8_t>(sum >> 8U));
    writer.raw(flag);
    return writer.finish();
}

std::optional<Frame> FrameDecoder::on_octet(std::uint8_t octet) {
    if (octet == flag) {
        // A closing flag, an opening one, or both: whatever lies before it ends here.
        auto frame = inside_ ? close() : std::nullopt;
        inside_ = true;
        size_ = 0;
        escaped_ = false;
        overflow_ = false;
        return frame;
    }
    if (!inside_) return std::nullopt;
    if (octet == escape) {
        escaped_ = true;
        return std::nullopt;
    }
    if (escaped_) {
        octet ^= flip;
        escaped_ = false;
    }
    if (size_ == octets_.size()) {
        overflow_ = true;
    } else {
        octets_[size_++] = octet;
    }
    return std::nullopt;
}

std::optional<Frame> FrameDecoder::close() {
    if (overflow_) {
        ++counters_.too_long;
        return std::nullopt;
    }
    if (size_ == 0) return std::nullopt;  // flags between frames
    if (size_ < 4) {
        ++counters_.too_short;
        return std::nullopt;
    }
    const Bytes whole = Bytes{octets_}.first(size_);
    const std::uint16_t sent =
        static_cast<std::uint16_t>(whole[size_ - 2] | (whole[size_ - 1] << 8U));
    if (fcs16(whole.first(size_ - 2)) != sent) {
        ++counters_.bad_fcs;
        return std::nullopt;
    }
    const unsigned control = whole[1];
    const Bytes data = whole.subspan(2, size_ - 4);
    Frame frame;
    if ((control & 1U) == 0) {  // the poll and receive-number bits are unused
        frame = {FrameKind::data, static_cast<std::uint8_t>((control >> 1U) & 7U), data};
    } else if ((control & 0x0FU) == 0x01U) {
        frame = {FrameKind::ack, static_cast<std::uint8_t>(control >> 5U), {}};
    } else if ((control & 0x0FU) == 0x09U) {
        frame = {FrameKind::nack, static_cast<std::uint8_t>(control >> 5U), {}};
    } else {
        ++counters_.bad_control;
        return std::nullopt;
    }
    ++counters_.frames;
    return frame;
}

}  // namespace romano::hdlc
