#include "firmware/hdlc/link.h"

#include <algorithm>

namespace romano::hdlc {

namespace {

constexpr std::uint8_t after(std::uint8_t seq) {
    return (seq + 1U) & 7U;
}
constexpr std::uint8_t before(std::uint8_t seq) {
    return (seq + 7U) & 7U;
}

}  // namespace

bool Link::send(Instant now, Bytes data) {
    if (waiting_ || data.size() > max_data) return false;
    std::copy(data.begin(), data.end(), data_.begin());
    data_size_ = data.size();
    waiting_ = true;
    write_data(now);
    return true;
}

std::optional<Bytes> Link::on_octet(Instant, std::uint8_t octet) {
    const auto frame = decoder_.on_octet(octet);
    if (!frame) return std::nullopt;
    if (frame->kind != FrameKind::data) {
        if (waiting_ && frame->seq == send_seq_) {
            waiting_ = false;
            send_seq_ = after(send_seq_);
        }
        return std::nullopt;
    }
    if (frame->seq == before(expect_seq_)) {  // our ACK was lost
        write_ack(frame->seq);
        return std::nullopt;
    }
    if (frame->seq != expect_seq_) return std::nullopt;
    write_ack(frame->seq);
    expect_seq_ = after(expect_seq_);
    return frame->data;
}

void Link::on_tick(Instant now) {
    if (!waiting_ || now < repeat_at_) return;
    ++repeats_;
    write_data(now);
}

// When the owner has not drained the line's buffer, a frame that does not fit is not written: the
// repetition, ours or the peer's, makes up for it.
void Link::write_data(Instant now) {
    out_size_ += encode({FrameKind::data, send_seq_, Bytes{data_}.first(data_size_)},
                        MutableBytes{out_}.subspan(out_size_));
    repeat_at_ = now + repeat_after_;
}

void Link::write_ack(std::uint8_t seq) {
    out_size_ += encode({FrameKind::ack, seq, {}}, MutableBytes{out_}.subspan(out_size_));
}

}  // namespace romano::hdlc
