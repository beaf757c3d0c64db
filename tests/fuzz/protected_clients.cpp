// What comes to a broker's protected and plain addresses, in front of the core: without a key
// nothing gets past a protected one but SEARCHGW, nobody gets past a plain one in the name of a
// client with a key, and who has a key goes on undisturbed.

#include "broker/protection/protected_clients.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "broker/protection/protected_node.h"
#include "romano/mqttsn/decode.h"
#include "romano/protection/robot_end.h"
#include "tests/fuzz/require.h"

using namespace romano;
using namespace romano::broker;

namespace {

using Octets = std::vector<std::uint8_t>;

constexpr std::array<std::uint8_t, 2> pingreq{0x02, 0x16};

struct Broker {
    Broker() {
        const std::array<ProtectedClient, 1> all{ProtectedClient{"r1", key}};
        clients.set_clients(all, {});
        sealed.packets = Endpoint::Packets::sealed;
    }
    Octets sealed_by_robot() {
        if (const auto bound = robot.reserve().to_store()) robot.reserve().on_stored(*bound);
        Octets packet(pingreq.size() + protection::most_overhead);
        packet.resize(robot.seal(pingreq, packet));
        return packet;
    }
    Bytes admit(const Endpoint& via, Bytes datagram) {
        actions.clear();
        const Bytes admitted = clients.admit(Instant{}, via, from, datagram, actions);
        if (clients.to_store()) clients.on_stored();
        return admitted;
    }

    const protection::RobotKey key{{0x5A}};
    const protection::DirectionKeys keys = protection::direction_keys(key);
    ProtectedClients clients{protection::SenderId{0xB0}, 0};
    protection::RobotEnd robot{keys, "r1", 0};
    Endpoint plain{.address = {127, 0, 0, 1}, .port = 1883, .family = Endpoint::Family::ipv4};
    Endpoint sealed = plain;
    Endpoint from{.address = {127, 0, 0, 2}, .port = 4711, .family = Endpoint::Family::ipv4};
    Actions actions;
};

bool is_in_the_name_of_r1(Bytes datagram) {
    auto frame = mqttsn::decode_frame(datagram);
    if (frame && frame->type == mqttsn::MsgType::encapsulated) {
        const auto wrapped = mqttsn::decode_encapsulated(*frame);
        if (!wrapped) return false;
        if (as_text(wrapped->wireless_node_id).starts_with(protected_mark)) return true;
        frame = mqttsn::decode_frame(wrapped->message);
    }
    if (!frame || frame->type != mqttsn::MsgType::connect) return false;
    const auto connect = mqttsn::decode_connect(frame->body);
    return connect && connect->client_id == "r1";
}

}  // namespace

/// Datagrams, each behind its length; the highest bit of that: to the plain address.
// NOLINTNEXTLINE(readability-identifier-naming): the name that libFuzzer calls
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    Broker broker;
    Bytes rest{data, size};
    while (!rest.empty()) {
        const bool is_plain = (rest[0] & 0x80U) != 0;
        const std::size_t length = std::min<std::size_t>(rest[0] & 0x7FU, rest.size() - 1);
        const Bytes datagram = rest.subspan(1, length);
        rest = rest.subspan(1 + length);
        const Bytes admitted = broker.admit(is_plain ? broker.plain : broker.sealed, datagram);
        if (is_plain) {
            REQUIRE(admitted.empty() || !is_in_the_name_of_r1(admitted));
        } else if (!admitted.empty()) {
            REQUIRE(mqttsn::decode_frame(admitted)->type == mqttsn::MsgType::searchgw);
        }
    }
    const Octets packet = broker.sealed_by_robot();
    const Bytes admitted = broker.admit(broker.sealed, packet);
    REQUIRE(admitted.size() > pingreq.size());
    REQUIRE(std::ranges::equal(admitted.last(pingreq.size()), pingreq));
    REQUIRE(broker.admit(broker.sealed, packet).empty());
    return 0;
}
