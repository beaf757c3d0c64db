// Clients with key files: no number twice, whoever ends when, and however many programs there are.

#include "romano/keys/client_packets.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <set>
#include <utility>

#include "romano/keys/key_error.h"
#include "romano/keys/key_folder.h"
#include "romano/protection/broker_end.h"
#include "tests/temporary_folder.h"

namespace romano::keys::client_packets_test {
namespace {

using Octets = std::vector<std::uint8_t>;
const Octets pingreq{2, 0x16};
const Octets connect{6, 4, 4, 1, 0, 10};

Octets copy(Bytes octets) {
    return {octets.begin(), octets.end()};
}

protection::Fields fields_of(Octets packet) {
    return protection::parse(packet)->fields();
}

struct Clients : testing::Test {
    Clients() { fleet.add({.brokers = {}, .robots = {"abcd1234"}, .operators = {"anna"}}); }

    tests::TemporaryFolder folder;
    KeyFolder fleet{folder.path()};
    std::filesystem::path robot = fleet.own_file("abcd1234", Role::robot);
    std::filesystem::path anna = fleet.own_file("anna", Role::person);
};

TEST_F(Clients, EachLifeOfARobotBeginsAboveAllNumbersOfTheLast) {
    std::set<std::uint32_t> numbers;
    for (int life = 0; life < 3; ++life) {
        ClientPackets packets(robot);
        for (int i = 0; i < 5'000; ++i) {
            const Octets packet = copy(packets.seal(pingreq));
            ASSERT_FALSE(packet.empty());
            ASSERT_TRUE(numbers.insert(fields_of(packet).number).second);
        }
    }
}

TEST_F(Clients, ARobotIsOneProgram) {
    auto first = std::make_unique<ClientPackets>(robot);
    EXPECT_EQ(first->client_id(), "abcd1234");
    EXPECT_THROW(ClientPackets{robot}, KeyError);
    first.reset();
    EXPECT_NO_THROW(ClientPackets{robot});
    EXPECT_THROW((ClientPackets{robot, "abcd1235"}), KeyError);
}

TEST_F(Clients, AProgramOfAPersonIsAClientOfItsOwnWithAKeyOfItsOwn) {
    std::vector<std::unique_ptr<ClientPackets>> programs;
    std::set<protection::SenderId> senders;
    for (unsigned n = 0; n < sessions_of_a_person; ++n) {
        programs.push_back(std::make_unique<ClientPackets>(anna));
        senders.insert(fields_of(copy(programs.back()->seal(pingreq))).sender);
    }
    EXPECT_EQ(programs.front()->client_id(), "anna");
    EXPECT_EQ(programs.back()->client_id(), "anna/15");
    EXPECT_EQ(senders.size(), sessions_of_a_person);
    EXPECT_THROW(ClientPackets{anna}, KeyError);
    programs[3].reset();
    EXPECT_EQ(ClientPackets{anna}.client_id(), "anna/3");
    EXPECT_EQ((ClientPackets{anna, "anna/3"}).client_id(), "anna/3");
}

TEST_F(Clients, AProgramBeginsAboveWhatAnotherOneOfThatPersonStored) {
    ClientPackets first(anna);
    std::uint32_t last = 0;
    for (int i = 0; i < 10'000; ++i) last = fields_of(copy(first.seal(pingreq))).number;
    ClientPackets second(anna);
    EXPECT_GT(fields_of(copy(second.seal(pingreq))).number, last);
}

TEST_F(Clients, ABrokerThatForgotTheBlockHearsTheNextConnect) {
    const ClientKey key = read_own_key(robot).client;
    const protection::DirectionKeys keys = protection::direction_keys(key_of(key, "abcd1234"));
    protection::Reserve reserve{0};
    reserve.on_stored(*reserve.to_store());
    protection::BrokerEnd before(keys, "abcd1234", {1}, reserve, std::nullopt);

    ClientPackets packets(robot);
    Octets packet = copy(packets.seal(connect));
    ASSERT_FALSE(before.open(packet).empty());
    const auto stored = before.to_store();
    ASSERT_TRUE(stored);
    Octets answer(64);
    answer.resize(before.seal(Octets{3, 5, 0}, answer));
    ASSERT_FALSE(packets.open(answer).empty());

    protection::BrokerEnd after(keys, "abcd1234", {1}, reserve, stored);
    packet = copy(packets.seal(pingreq));
    EXPECT_TRUE(after.open(packet).empty());
    packet = copy(packets.seal(connect));
    EXPECT_FALSE(after.open(packet).empty());
}

TEST_F(Clients, NoBrokerForDaysUsesFewBlocks) {
    ClientPackets packets(robot);
    const std::uint32_t first = fields_of(copy(packets.seal(connect))).number;
    std::uint32_t last = first;
    for (int i = 0; i < 800; ++i) last = fields_of(copy(packets.seal(connect))).number;
    EXPECT_LE(last - first, 101 * protection::numbers_a_block);
    EXPECT_GE(last - first, 90 * protection::numbers_a_block);
}

}  // namespace
}  // namespace romano::keys::client_packets_test
