// Section 6.5: REGISTER from the client.

#include "tests/conformance/suite.h"

namespace romano::conformance::register_test {
namespace {

CONFORMANCE_SUITE(S6_5_Register, PatientSuite);

TEST_P(S6_5_Register, a_GivesAnIdThatIsNotReserved) {
    Client& robot = connected();
    robot.registers(topic());
}

TEST_P(S6_5_Register, a_TheSameNameAlwaysHasTheSameId) {  // G15
    Client& robot = connected();
    const unsigned id = robot.registers(topic());
    EXPECT_EQ(robot.registers(topic()), id);
    EXPECT_EQ(robot.subscribes(topic()), id);
    EXPECT_EQ(robot.registers(topic()), id);
}

TEST_P(S6_5_Register, a_OtherNamesHaveOtherIds) {
    Client& robot = connected();
    const unsigned a = robot.registers(topic("a"));
    EXPECT_NE(robot.registers(topic("A")), a);
    EXPECT_NE(robot.registers(topic("a/")), a);
    EXPECT_NE(robot.registers("/" + topic("a")), a);
}

TEST_P(S6_5_Register, a_TheIdInTheRequestIsIgnored) {
    Client& robot = connected();
    const unsigned id = robot.registers(topic());
    robot.says(register_topic(0x1234, 7, topic()));
    robot.hears(regack(id, 7, accepted));
}

TEST_P(S6_5_Register, a_ARepetitionIsAnsweredAlike) {
    Client& robot = connected();
    robot.says(register_topic(0, 7, topic()));
    const Octets answer = robot.next();
    robot.says(register_topic(0, 7, topic()));
    EXPECT_EQ(robot.next(), answer);
}

TEST_P(S6_5_Register, g15_IdsCountUpFrom1) {
    Client& robot = connected();
    EXPECT_EQ(robot.registers(topic("a")), 1);
    EXPECT_EQ(robot.registers(topic("b")), 2);
}

TEST_P(S6_5_Register, g23_MsgId0IsCopied) {
    Client& robot = connected();
    const unsigned id = robot.registers(topic());
    robot.says(register_topic(0, 0, topic()));
    robot.hears(regack(id, 0, accepted));
}

TEST_P(S6_5_Register, s7_3a_IdsHoldForOneClient) {
    Client& robot = connected();
    Client& other = connected();
    robot.registers(topic("a"));
    const unsigned id = robot.registers(topic("b"));
    other.says(publish(qos1, id, 9, "x"));
    other.hears(puback(id, 9, invalid_topic_id));
}

TEST_P(S6_5_Register, b_EmptyNamesAndNamesWithWildcardsAreRefused) {
    Client& robot = connected();
    for (const std::string name : {"", "#", "+", "a/+", "a+", "a#b", "a/#/b"}) {
        robot.says(register_topic(0, 7, name));
        robot.hears(regack(0, 7, not_supported));
    }
}

TEST_P(S6_5_Register, b_NamesThatAreNoUtf8AreRefused) {  // G26
    Client& robot = connected();
    const std::vector<std::string> wrong{
        "\xFF",                 // no octet of UTF-8
        "a\xC3",                // cut off
        "\xC0\x80",             // overlong
        "\xE0\x80\xAF",         // overlong
        "\xED\xA0\x80",         // a surrogate
        "\xF4\x90\x80\x80",     // beyond U+10FFFF
        "\x80",                 // a continuation without a start
        std::string{"a\0b", 3}  // U+0000
    };
    for (const std::string& name : wrong) {
        robot.says(register_topic(0, 7, name));
        robot.hears(regack(0, 7, not_supported));
    }
}

TEST_P(S6_5_Register, b_NamesOfAllOfUtf8AreTaken) {
    Client& robot = connected();
    for (const std::string name :
         {"\xC3\xA9", "\xE2\x82\xAC", "\xF0\x9F\xA4\x96", " ", "/", "//"}) {
        robot.registers(topic(name));
    }
}

TEST_P(S6_5_Register, LongNamesAreTaken) {
    Client& robot = connected();
    Client& other = connected();
    const std::string name = topic(std::string(2'000, 'n'));
    const unsigned id = robot.registers(name);
    const unsigned at_other = other.subscribes(name);
    robot.publishes(id, "x");
    other.hears_publish(no_flags, at_other, "x");
}

TEST_P(S6_5_Register, ManyTopicsAreTaken) {
    Client& robot = connected();
    for (unsigned n = 1; n <= 300; ++n) robot.registers(topic(std::to_string(n)));
}

}  // namespace
}  // namespace romano::conformance::register_test
