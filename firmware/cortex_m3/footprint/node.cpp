// MQTT-SN client, ROMANO node, mailbox and discovery together, buffers of 512 octets: for their
// size.

#include "romano/node/node.h"

#include "firmware/cortex_m3/footprint/limits.h"
#include "romano/client/discovery.h"

using namespace romano;

namespace {

std::uint8_t volatile line;  // where datagrams come from and go to, of any size

struct Port final : node::Port {
    void send(Bytes datagram) override { line = datagram[0]; }
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
        const Bytes octets = Bytes{room}.first(line);
        for (std::uint8_t& octet : room) octet = line;
        discovery.on_datagram(now, {.address = {line, line, line, line}, .port = line}, octets);
        robot.on_datagram(now, octets, port);
        if (discovery.on_tick(now, room) != 0) line = room[0];
        if (robot.next_wakeup() <= now) robot.on_tick(now, port);
        robot.publish(now, "pose", message::NormalData{octets}, mqttsn::Qos{line}, port);
        romano_command command;
        if (romano_mailbox_get(&mailbox, &command)) line = command.arguments[0];
    }
}
