// A controller as on the Cortex-M3, a robot behind the line to its radio, under frames and
// datagrams that are none: a million of each. They are dropped and counted, and the robot goes on.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <optional>
#include <vector>

#include "firmware/radio/line.h"
#include "firmware/robot/address.h"
#include "firmware/robot/robot.h"
#include "romano/base/random.h"

namespace romano::firmware::bad_line_test {
namespace {

using namespace std::chrono_literals;
using Octets = std::vector<std::uint8_t>;

constexpr int a_million = 1'000'000;

Endpoint broker() {
    return {.address = {10, 0, 0, 7}, .port = 1883, .family = Endpoint::Family::ipv4};
}

/// cortex_m3/main.cpp without the chip.
class ControllerBehindALine final : public Controller {
public:
    ControllerBehindALine() {
        RobotSettings settings;
        settings.node.id = *message::RomanoId::parse("abcd1234");
        settings.broker = broker();
        settings.timing.t_retry = 2s;
        robot.emplace(settings, board_, *this);
    }
    void hear(Bytes octets) {
        heard_ = octets;
        robot->run();
        line.on_tick(Instant{std::chrono::milliseconds{now_ms}});
        line.clear_line_out();
    }

    std::uint64_t now_ms = 0;
    std::uint32_t sent = 0;
    radio::Line line{radio::PacketType::send_udp, to_send_, to_receive_, 50ms};
    std::optional<Robot<>> robot;

private:
    static ControllerBehindALine& self(void* us) {
        return *static_cast<ControllerBehindALine*>(us);
    }
    static std::uint64_t read_clock(void* us) { return self(us).now_ms; }
    static void send(void* us, const romano_address* to, const std::uint8_t* octets,
                     std::uint32_t size) {
        ++self(us).sent;
        self(us).line.send(Instant{std::chrono::milliseconds{self(us).now_ms}},
                           {endpoint_of(*to), radio::unknown_dbm, {octets, size}});
    }
    static const std::uint8_t* receive(void* us, romano_address* from, std::uint32_t* size) {
        Bytes& heard = self(us).heard_;
        while (!heard.empty()) {
            const auto input = self(us).line.on_octet(
                Instant{std::chrono::milliseconds{self(us).now_ms}}, heard[0]);
            heard = heard.subspan(1);
            if (!input.datagram) continue;
            *from = address_of(input.datagram->peer);
            *size = static_cast<std::uint32_t>(input.datagram->octets.size());
            return input.datagram->octets.data();
        }
        return nullptr;
    }

    std::array<std::uint8_t, 240> to_send_{};
    std::array<std::uint8_t, 264> to_receive_{};
    const romano_board board_{this, read_clock, send, receive, nullptr};
    Bytes heard_;
};

class BadLine : public testing::Test {
protected:
    /// A datagram from the broker in one frame.
    Octets framed(std::uint8_t seq, Bytes datagram) {
        std::array<std::uint8_t, hdlc::max_data> packet{};
        std::size_t at = 0;
        const std::size_t size =
            radio::write_part(radio::PacketType::forward_udp,
                              {broker(), radio::unknown_dbm, datagram}, 0, at, packet);
        return encoded(seq, Bytes{packet}.first(size));
    }
    static Octets encoded(std::uint8_t seq, Bytes data) {
        Octets frame(hdlc::max_encoded);
        frame.resize(hdlc::encode({hdlc::FrameKind::data, seq, data}, frame));
        return frame;
    }
    Octets any_octets(std::uint32_t most) {
        Octets octets(random.below(most + 1));
        for (std::uint8_t& octet : octets) octet = static_cast<std::uint8_t>(random.next());
        return octets;
    }

    Random random{1};
    ControllerBehindALine controller;
};

const Octets connack{3, 0x05, 0};

TEST_F(BadLine, AMillionBentFramesAreCountedAndTheNextGoodOneIsHeard) {
    const Octets good = framed(0, connack);
    for (int i = 0; i < a_million; ++i) {
        Octets bent = good;
        bent[1 + random.below(static_cast<std::uint32_t>(bent.size()) - 2)] ^=
            static_cast<std::uint8_t>(1U << random.below(8));
        if (random.happens(100'000)) bent.resize(1 + random.below(8));
        controller.hear(bent);
    }
    const hdlc::FrameCounters& counted = controller.line.link().frame_counters();
    EXPECT_EQ(counted.frames, 0U);
    EXPECT_GE(counted.bad_fcs + counted.too_short + counted.too_long, 900'000U);
    EXPECT_EQ(controller.robot->node().phase(), node::Phase::connecting);
    controller.hear(good);
    controller.hear(good);  // were the last bent one without its end, this one has begun anew
    EXPECT_EQ(controller.robot->node().phase(), node::Phase::subscribing);
}

TEST_F(BadLine, AMillionFramesWithAnythingInThemLeaveTheRobotWorking) {
    for (int i = 0; i < a_million; ++i) {
        const auto seq = static_cast<std::uint8_t>(i % 8);
        const Octets what = any_octets(40);
        controller.hear(random.happens(500'000) ? framed(seq, what) : encoded(seq, what));
        controller.now_ms += random.below(3);
    }
    EXPECT_EQ(controller.line.link().frame_counters().frames,
              static_cast<std::uint32_t>(a_million));
    const std::uint32_t sent = controller.sent;
    for (int i = 0; i < 60'000; ++i) {  // a minute: it asks its broker again, or for another one
        controller.hear({});
        ++controller.now_ms;
    }
    EXPECT_GT(controller.sent, sent);
}

}  // namespace
}  // namespace romano::firmware::bad_line_test
