// Both ends of protected packets under any octets. Without the key nothing is accepted, and who has
// it goes on undisturbed; what is sealed opens to itself, once.

#include <algorithm>
#include <array>
#include <vector>

#include "romano/protection/broker_end.h"
#include "romano/protection/robot_end.h"
#include "romano/protection/sha256.h"
#include "tests/fuzz/require.h"
#include "tests/fuzz/script.h"

using namespace romano;
using namespace romano::protection;

namespace {

using Octets = std::vector<std::uint8_t>;

/// Of the input's own: a fuzzer that sees our packets compared puts them into inputs.
DirectionKeys keys_for(Bytes input) {
    Sha256 hash;
    hash.add(input);
    const auto digest = hash.finish();
    RobotKey key;
    std::copy_n(digest.begin(), key.octets.size(), key.octets.begin());
    return direction_keys(key);
}

constexpr std::array<std::uint8_t, 2> pingreq{0x02, 0x16};

class Cell {
public:
    explicit Cell(const DirectionKeys& of_robot) : keys(of_robot) {}
    void store() {
        if (const auto bound = robot.reserve().to_store()) robot.reserve().on_stored(*bound);
        if (const auto bound = reserve.to_store()) reserve.on_stored(*bound);
        if (const auto heard = broker.to_store()) broker.on_stored(*heard);
    }
    /// What the robot seals; empty for a message that is none.
    Octets seal(Bytes message) {
        store();
        Octets packet(message.size() + most_overhead);
        packet.resize(robot.seal(message, packet));
        return packet;
    }
    Octets answer(Bytes message) {
        store();
        Octets packet(message.size() + most_overhead);
        packet.resize(broker.seal(message, packet));
        return packet;
    }

    const DirectionKeys keys;
    RobotEnd robot{keys, "abcd1234", 0};
    Reserve reserve{0};
    BrokerEnd broker{keys, "abcd1234", {7}, reserve, std::nullopt};
};

/// The input as a datagram, and as what stands behind the header of a packet that would be in
/// order.
void forge(Bytes input, Cell& cell) {
    Octets datagram{input.begin(), input.end()};
    REQUIRE(cell.robot.open(datagram).empty());
    datagram.assign(input.begin(), input.end());
    REQUIRE(cell.broker.open(datagram).empty());
    if (input.size() > 200) return;
    for (Octets packet : {cell.seal(pingreq), cell.answer(pingreq)}) {
        packet.resize(20);
        packet.insert(packet.end(), input.begin(), input.end());
        packet[0] = static_cast<std::uint8_t>(packet.size());
        Octets again = packet;
        REQUIRE(cell.robot.open(packet).empty());
        REQUIRE(cell.broker.open(again).empty());
    }
}

/// The input's octets change a packet that would be in order.
void damage(Bytes input, Cell& cell) {
    fuzz::Script script{input};
    while (!script.is_over()) {
        const Octets good = cell.seal(pingreq);
        Octets packet = good;
        const std::uint8_t at = script.octet();
        packet[at % packet.size()] = script.octet();
        const bool is_good = packet == good;
        REQUIRE(is_good == !cell.broker.open(packet).empty());
    }
}

void carry(Bytes message, Cell& cell) {
    const Octets packet = cell.seal(message);
    if (packet.empty()) return;
    Octets datagram = packet;
    const Bytes opened = cell.broker.open(datagram);
    const bool is_refused = message.size() < 2 || message[1] == 0xFE;
    REQUIRE(is_refused || std::equal(opened.begin(), opened.end(), message.begin(), message.end()));
    datagram = packet;
    REQUIRE(cell.broker.open(datagram).empty());  // once
}

}  // namespace

// NOLINTNEXTLINE(readability-identifier-naming): the name that libFuzzer calls
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const Bytes input{data, size};
    Cell cell{keys_for(input)};
    carry(pingreq, cell);  // the broker has heard the robot
    forge(input, cell);
    damage(input, cell);
    carry(input, cell);
    Octets packet = cell.answer(pingreq);
    REQUIRE(!cell.robot.open(packet).empty());
    return 0;
}
