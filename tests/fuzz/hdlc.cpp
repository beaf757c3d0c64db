// The line between controller and radio under any octets: a decoded frame encodes to itself, the
// link's output always fits, and no octets make the ends of a line fail.

#include <array>
#include <vector>

#include "firmware/hdlc/frame.h"
#include "firmware/radio/line.h"
#include "tests/fuzz/require.h"

using namespace romano;

namespace {

void decode_and_encode(Bytes input) {
    hdlc::FrameDecoder decoder;
    for (const std::uint8_t octet : input) {
        const auto frame = decoder.on_octet(octet);
        if (!frame) continue;
        REQUIRE(frame->seq < 8);
        REQUIRE(frame->data.size() <= hdlc::max_data);
        const std::vector<std::uint8_t> data{frame->data.begin(), frame->data.end()};
        std::array<std::uint8_t, hdlc::max_encoded> octets{};
        const std::size_t size = hdlc::encode({frame->kind, frame->seq, data}, octets);
        REQUIRE(size != 0);
        hdlc::FrameDecoder again;
        std::size_t frames = 0;
        for (std::size_t i = 0; i < size; ++i) {
            const auto second = again.on_octet(octets[i]);
            if (!second) continue;
            ++frames;
            REQUIRE(second->kind == frame->kind && second->seq == frame->seq);
            REQUIRE(std::equal(data.begin(), data.end(), second->data.begin(), second->data.end()));
        }
        REQUIRE(frames == 1);
    }
}

void hear(Bytes input) {
    std::array<std::uint8_t, 300> to_send{};
    std::array<std::uint8_t, 100> to_receive{};
    radio::Line line{radio::PacketType::send_udp, to_send, to_receive,
                     std::chrono::milliseconds{50}};
    Instant now{};
    for (const std::uint8_t octet : input) {
        now += std::chrono::milliseconds{1};
        const auto result = line.on_octet(now, octet);
        if (result.datagram) {
            REQUIRE(result.datagram->octets.size() <= to_receive.size());
            line.send(now, *result.datagram);  // an echo
        }
        line.on_tick(now);
        REQUIRE(line.line_out().size() <= 512);
        line.clear_line_out();
    }
}

/// The octets as the data of well-formed frames, which are rarer among any octets.
void hear_framed(Bytes input) {
    std::vector<std::uint8_t> octets;
    for (unsigned seq = 0; !input.empty(); ++seq) {
        const Bytes data = input.first(std::min<std::size_t>(input.size(), 1U + input[0] % 64U));
        input = input.subspan(data.size());
        std::array<std::uint8_t, hdlc::max_encoded> frame{};
        const std::size_t size =
            hdlc::encode({hdlc::FrameKind::data, static_cast<std::uint8_t>(seq % 8), data}, frame);
        octets.insert(octets.end(), frame.begin(),
                      frame.begin() + static_cast<std::ptrdiff_t>(size));
    }
    hear(octets);
}

}  // namespace

// NOLINTNEXTLINE(readability-identifier-naming): the name that libFuzzer calls
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const Bytes input{data, size};
    decode_and_encode(input);
    hear(input);
    hear_framed(input);
    return 0;
}
