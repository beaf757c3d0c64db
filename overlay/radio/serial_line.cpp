#include "overlay/radio/serial_line.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace romano::radio {
namespace {

constexpr std::uint8_t flag = 0x7E;
constexpr std::uint8_t escape = 0x7D;

Duration octets_time(std::uint32_t baud, std::size_t octets) {
    constexpr std::int64_t bits_an_octet = 10;
    const auto bits = static_cast<std::int64_t>(octets) * bits_an_octet;
    return std::chrono::nanoseconds{bits * std::nano::den / baud};
}

}  // namespace

Duration line_time(std::uint32_t baud, const Framing& framing, Bytes datagram) {
    const std::size_t frames =
        std::max<std::size_t>(1, (datagram.size() + framing.part_max - 1) / framing.part_max);
    const auto stuffed = static_cast<std::size_t>(std::count_if(
        datagram.begin(), datagram.end(), [](auto o) { return o == flag || o == escape; }));
    return octets_time(baud, datagram.size() + stuffed + frames * framing.octets +
                                 (frames - 1) * framing.answer_octets);
}

Duration answer_time(std::uint32_t baud, const Framing& framing) {
    return octets_time(baud, framing.answer_octets);
}

SerialLine::SerialLine(sim::EventQueue& events, std::optional<std::uint32_t> baud,
                       const Framing& framing, std::size_t room, Deliver deliver)
    : events_(events), baud_(baud), framing_(framing), room_(room), deliver_(std::move(deliver)) {}

bool SerialLine::send(Carried datagram) {
    if (waiting_.size() >= room_) {
        ++lost_;
        return false;
    }
    waiting_.push_back(std::move(datagram));
    if (waiting_.size() == 1) begin();
    return true;
}

void SerialLine::begin() {
    const Duration time =
        baud_ ? line_time(*baud_, framing_, waiting_.front().octets) : Duration{0};
    events_.after(time, [this] { arrive(); });
}

void SerialLine::arrive() {
    refused_ = !deliver_(waiting_.front());
    if (refused_) return;
    events_.after(baud_ ? answer_time(*baud_, framing_) : Duration{0}, [this] {
        waiting_.pop_front();
        if (!waiting_.empty()) begin();
    });
}

void SerialLine::go_on() {
    if (refused_) arrive();
}

}  // namespace romano::radio
