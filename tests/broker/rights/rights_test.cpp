// Who may do what: rules with the keys that there are.

#include "broker/rights/rights.h"

#include <gtest/gtest.h>

#include <array>
#include <string>
#include <vector>

#include "broker/protection/protected_node.h"
#include "romano/control/messages.h"
#include "romano/message/codec.h"

namespace romano::rights::rights_test {
namespace {

using broker::Extent;
using broker::Speaker;
using Octets = std::vector<std::uint8_t>;

template <typename M>
Octets octets_of(const M& message) {
    Octets octets(message::max_message);
    octets.resize(message::encode(message, octets));
    return octets;
}

const Octets text{'x'};
const Octets movement = octets_of(message::MovementControl{
    message::MovementType::front, as_octets(std::string_view{"\0\0\0\1", 4})});
const Octets loop_message{control::data_type, 4, 9, 0};

message::RomanoId id_of(std::string_view digits) {
    return message::RomanoId::parse(digits).value_or(message::RomanoId{});
}

/// Somebody with a key, and how the broker knows.
struct Somebody {
    explicit Somebody(std::string client_id)
        : id(std::move(client_id)), node_id(broker::protected_node_id(id)) {}
    operator Speaker() const {
        Endpoint via{.address = {127, 0, 0, 1}, .port = 1883, .family = Endpoint::Family::ipv4};
        via.packets = Endpoint::Packets::sealed;
        return {via, node_id, id};
    }
    std::string id;
    std::string node_id;
};

Speaker plain_client(std::string_view id = "somebody", std::string_view node_id = {}) {
    return {
        {.address = {127, 0, 0, 1}, .port = 1884, .family = Endpoint::Family::ipv4}, node_id, id};
}

struct Fleet {
    explicit Fleet(std::string_view rules = usual_rules())
        : rights(*parse(rules), std::vector<KeyOwner>{{"0000000a", Role::robot},
                                                      {"0000000b", Role::robot},
                                                      {"anna", Role::person}}) {}
    Rights rights;
    Somebody a{"0000000a"};
    Somebody b{"0000000b"};
    Somebody anna{"anna/3"};
};

TEST(UsualRights, ARobotHasItsOwnTopicsAndCommands) {
    const Fleet fleet;
    EXPECT_TRUE(fleet.rights.may_publish(fleet.a, "robots/0000000a/pose", text));
    EXPECT_TRUE(fleet.rights.may_publish(fleet.a, "pose/0000000a", text));
    EXPECT_TRUE(fleet.rights.may_read(fleet.a, "0000000a"));
    EXPECT_TRUE(fleet.rights.may_read(fleet.a, "common"));
    EXPECT_FALSE(fleet.rights.may_publish(fleet.a, "robots/0000000b/pose", text));
    EXPECT_FALSE(fleet.rights.may_read(fleet.a, "robots/0000000b/pose"));
    EXPECT_FALSE(fleet.rights.may_read(fleet.a, "0000000b"));
    EXPECT_FALSE(fleet.rights.may_read(fleet.a, "$SYS/brokers/b1"));
}

TEST(UsualRights, RobotsDoNotMoveEachOther) {
    const Fleet fleet;
    EXPECT_FALSE(fleet.rights.may_publish(fleet.a, "0000000b", movement));
    EXPECT_FALSE(fleet.rights.may_publish(fleet.a, "common", movement)) << "that is all of them";
    EXPECT_FALSE(fleet.rights.may_publish(fleet.a, "0000000b", loop_message));
}

/// What a robot listens to is never what another one may publish, however topics are named.
TEST(UsualRights, NoTopicIsOneRobotsToPublishAndAnothersToRead) {
    const Fleet fleet;
    const std::array<std::string, 4> words = {"0000000a", "0000000b", "robots", "x"};
    for (const auto& first : words) {
        EXPECT_FALSE(fleet.rights.may_publish(fleet.a, first, text) &&
                     fleet.rights.may_read(fleet.b, first))
            << first;
        for (const auto& second : words) {
            for (const auto& third : words) {
                const std::string topic = first + "/" + second + "/" + third;
                EXPECT_FALSE(fleet.rights.may_publish(fleet.a, topic, text) &&
                             fleet.rights.may_read(fleet.b, topic))
                    << topic;
            }
        }
    }
}

TEST(UsualRights, ARobotAnnouncesItselfInItsOwnNameAlone) {
    const Fleet fleet;
    const Octets beat = octets_of(message::Heartbeat{id_of("0000000a")});
    const Octets request = octets_of(message::ConnectionRequest{id_of("0000000a")});
    const Octets list = octets_of(message::RequestConnectedNodes{id_of("0000000a")});
    EXPECT_TRUE(fleet.rights.may_publish(fleet.a, "common", beat));
    EXPECT_TRUE(fleet.rights.may_publish(fleet.a, "init-info", request));
    EXPECT_TRUE(fleet.rights.may_publish(fleet.a, "init-info", list));
    EXPECT_FALSE(fleet.rights.may_publish(fleet.b, "common", beat));
    EXPECT_FALSE(fleet.rights.may_publish(fleet.b, "init-info", request));
    EXPECT_FALSE(fleet.rights.may_publish(fleet.b, "init-info", list));
    EXPECT_FALSE(fleet.rights.may_publish(fleet.a, "init-info", text));
    EXPECT_TRUE(fleet.rights.may_publish_something(fleet.a, "common"));
}

/// In each, the operators may set rights or not.
constexpr std::string_view others = "group operators\ntopic write $ROMANO/rights\n";
constexpr std::string_view without_setters = "group operators\ntopic readwrite #\n";

TEST(RightsAreSet, ByOperatorsAloneWhomARuleLets) {
    const Fleet fleet;
    EXPECT_TRUE(fleet.rights.may_publish_something(fleet.anna, rights_topic));
    EXPECT_TRUE(fleet.rights.may_publish(fleet.anna, rights_topic, as_octets(others)));
    EXPECT_TRUE(fleet.rights.may_publish(fleet.anna, rights_topic, {})) << "takes them back";
    EXPECT_FALSE(fleet.rights.may_publish(plain_client(), rights_topic, as_octets(others)));
    const Fleet generous{
        "group plain\ntopic write $ROMANO/rights\ngroup robots\ntopic write $ROMANO/rights\n"
        "group uplink\ntopic write $ROMANO/rights\n"};
    const Speaker uplink_itself{.via = {}, .node_id = {}, .client_id = {}, .is_owner = true};
    const Speaker robot = generous.a;
    for (const Speaker& other : {robot, plain_client(), uplink_itself}) {
        EXPECT_FALSE(generous.rights.may_publish_something(other, rights_topic));
        EXPECT_FALSE(generous.rights.may_publish(other, rights_topic, as_octets(others)));
    }
    const Fleet strict{without_setters};
    EXPECT_FALSE(strict.rights.may_publish(strict.anna, rights_topic, as_octets(others)));
}

TEST(RightsAreSet, NeverSoThatWhoSetsThemCouldNotDoItAgain) {
    const Fleet fleet;
    EXPECT_FALSE(fleet.rights.may_publish(fleet.anna, rights_topic, as_octets(without_setters)));
    EXPECT_FALSE(fleet.rights.may_publish(
        fleet.anna, rights_topic,
        as_octets(std::string{others} + "user anna\ntopic deny $ROMANO/rights\n")));
}

TEST(RightsAreSet, NeverToATextThatIsNone) {
    const Fleet fleet;
    EXPECT_FALSE(fleet.rights.may_publish(fleet.anna, rights_topic, as_octets("topci read #\n")));
    EXPECT_FALSE(fleet.rights.may_publish(fleet.anna, rights_topic, movement));
}

TEST(UsualRights, OperatorsMoveRobotsAndReadAll) {
    const Fleet fleet;
    EXPECT_TRUE(fleet.rights.may_publish(fleet.anna, "0000000b", movement));
    EXPECT_TRUE(fleet.rights.may_publish(fleet.anna, "common", movement));
    EXPECT_EQ(fleet.rights.may_read_of(fleet.anna, "#"), Extent::all);
    EXPECT_EQ(fleet.rights.may_read_of(fleet.anna, "$SYS/brokers/+"), Extent::all);
}

TEST(UsualRights, PlainClientsDoWhatTheyAlwaysDid) {
    const Fleet fleet;
    EXPECT_TRUE(fleet.rights.may_publish(plain_client(), "0000000b", movement));
    EXPECT_TRUE(fleet.rights.may_publish(plain_client(""), "a", text)) << "QoS -1";
    EXPECT_EQ(fleet.rights.may_read_of(plain_client(), "#"), Extent::all);
}

TEST(Rights, WhoSomebodyIsIsDecidedByTheKeyAlone) {
    const Fleet fleet("group plain\npattern write %i\nuser anna\ntopic readwrite secret\n");
    EXPECT_TRUE(fleet.rights.may_read(fleet.anna, "secret"));
    EXPECT_FALSE(fleet.rights.may_read(plain_client("anna"), "secret"));
    EXPECT_FALSE(fleet.rights.may_read(plain_client("x", "protected:anna"), "secret"))
        << "a forwarder may call its nodes so where nobody has keys";
    EXPECT_TRUE(fleet.rights.may_publish(plain_client("x"), "x", text));
    const Somebody withdrawn("carl");
    EXPECT_FALSE(fleet.rights.may_publish(withdrawn, "carl", text));
}

TEST(Rights, DenyGoesBeforeAllElse) {
    const Fleet fleet(
        "group operators\ntopic readwrite #\nuser anna\ntopic deny secret/#\n"
        "topic read secret/a\n");
    EXPECT_FALSE(fleet.rights.may_read(fleet.anna, "secret/a"));
    EXPECT_FALSE(fleet.rights.may_publish(fleet.anna, "secret/a", text));
    EXPECT_EQ(fleet.rights.may_read_of(fleet.anna, "#"), Extent::some);
    EXPECT_EQ(fleet.rights.may_read_of(fleet.anna, "secret/+"), Extent::none);
    EXPECT_EQ(fleet.rights.may_read_of(fleet.anna, "public/#"), Extent::all);
}

TEST(Rights, WhatNoRuleAllowsIsRefused) {
    const Fleet fleet("user anna\ntopic read a\n");
    EXPECT_FALSE(fleet.rights.may_publish(fleet.anna, "a", text));
    EXPECT_FALSE(fleet.rights.may_read(fleet.anna, "b"));
    EXPECT_FALSE(fleet.rights.may_publish(fleet.a, "0000000a", text));
    EXPECT_FALSE(fleet.rights.may_publish(plain_client(), "a", text));
    EXPECT_EQ(fleet.rights.may_read_of(fleet.a, "#"), Extent::none);
}

TEST(Rights, AGroupsRulesAreItsMembers) {
    const Fleet fleet("group leaders\nmember 0000000a\ntopic write +/goal\n");
    EXPECT_TRUE(fleet.rights.may_publish(fleet.a, "b/goal", text));
    EXPECT_FALSE(fleet.rights.may_publish(fleet.b, "b/goal", text));
}

TEST(Rights, ALoopMovesNobodyButThePlantByCommandsOfTheLoop) {
    const Fleet fleet("user 0000000a\ntopic loop 0000000b\n");
    EXPECT_TRUE(fleet.rights.may_publish(fleet.a, "0000000b", loop_message));
    EXPECT_FALSE(fleet.rights.may_publish(fleet.a, "0000000b", movement));
    EXPECT_FALSE(fleet.rights.may_publish(fleet.a, "0000000b", Octets{control::data_type, 9, 9}));
    EXPECT_FALSE(fleet.rights.may_publish(fleet.b, "0000000a", loop_message));
}

TEST(Rights, PeopleAreToldWhoItWas) {
    const Fleet fleet;
    EXPECT_EQ(fleet.rights.name_of(fleet.a), "robot 0000000a");
    EXPECT_EQ(fleet.rights.name_of(fleet.anna), "operator anna/3");
    EXPECT_EQ(fleet.rights.name_of(plain_client()), "plain client 'somebody'");
    EXPECT_EQ(fleet.rights.name_of(plain_client("")), "a plain client without a session");
    EXPECT_EQ(fleet.rights.name_of(Somebody("carl")), "withdrawn client carl");
}

}  // namespace
}  // namespace romano::rights::rights_test
