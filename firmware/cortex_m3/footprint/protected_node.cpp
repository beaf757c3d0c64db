// What footprint/node.cpp has, and each datagram to and from the broker protected: for its size.
// Packets have 255 octets at most, more than a frame of a small radio.

#include "firmware/cortex_m3/footprint/limits.h"
#include "romano/client/discovery.h"
#include "romano/node/node.h"
#include "romano/protection/robot_end.h"

using namespace romano;

namespace {

std::uint8_t volatile line;  // where datagrams come from and go to, of any size
std::uint32_t volatile flash;

const protection::DirectionKeys keys{{1}, {2}};

struct Port final : node::Port {
    void send(Bytes datagram) override {
        if (const auto bound = end.reserve().to_store()) {
            flash = *bound;
            end.reserve().on_stored(*bound);
        }
        if (end.seal(datagram, packet) != 0) line = packet[0];
    }

    protection::RobotEnd end{keys, "abcd1234", flash};
    std::uint8_t packet[255];
};

}  // namespace

extern "C" void on_systick() {}
extern "C" void on_uart1() {}

int main() {
    static Port port;
    static client::Client<Limits> core;
    static client::OutputFor<Limits> out;
    static romano_mailbox mailbox;
    static client::Discovery discovery{{}, 1};
    static node::Node robot{core, out, mailbox, {}};
    Instant now{};
    discovery.search(now);
    robot.start(now, port);
    for (;;) {
        now += Duration{1};
        std::uint8_t room[255];
        const MutableBytes octets = MutableBytes{room}.first(line);
        for (std::uint8_t& octet : room) octet = line;
        discovery.on_datagram(now, {.address = {line, line, line, line}, .port = line}, octets);
        const Bytes message = port.end.open(octets);
        if (!message.empty()) robot.on_datagram(now, message, port);
        if (discovery.on_tick(now, room) != 0) line = room[0];
        if (robot.next_wakeup() <= now) robot.on_tick(now, port);
        robot.publish(now, "pose", message::NormalData{octets}, mqttsn::Qos{line}, port);
        romano_command command;
        if (romano_mailbox_get(&mailbox, &command)) line = command.arguments[0];
    }
}
