// The MQTT-SN client alone, with all that a program calls of it to publish and receive at QoS 0 to
// 2 with buffers of 512 octets: for its size.

#include "romano/client/client.h"

#include "firmware/cortex_m3/footprint/limits.h"

using namespace romano;

namespace {

std::uint8_t volatile line;  // where datagrams come from and go to, of any size

void drain(const client::Output& out) {
    for (const Bytes datagram : out.datagrams()) line = datagram[0];
}

}  // namespace

extern "C" void on_systick() {}
extern "C" void on_uart1() {}

int main() {
    static client::Client<Limits> core;
    static client::OutputFor<Limits> out;
    Instant now{};
    core.connect(now, {.client_id = "abcd1234"}, out);
    (void)core.subscribe(now, client::topic_name("abcd1234"), mqttsn::Qos::exactly_once, out);
    for (;;) {
        now += Duration{1};
        std::uint8_t room[255];
        const Bytes octets = Bytes{room}.first(line);
        for (std::uint8_t& octet : room) octet = line;
        core.on_datagram(now, octets, out);
        drain(out);
        (void)core.publish(now, client::topic_name("pose"), octets, {.qos = mqttsn::Qos{line}},
                           out);
        drain(out);
        if (core.next_wakeup() <= now) core.on_tick(now, out);
        drain(out);
    }
}
