// Section 5.2 and 5.3: length forms, message types, flags; and what is no message at all.

#include <random>

#include "tests/conformance/suite.h"

namespace romano::conformance::frame_test {
namespace {

CONFORMANCE_SUITE(S5_2_Frame, PatientSuite);

/// The datagram is no message: no answer, and the session that sent it goes on.
#define EXPECT_DROPPED(client, datagram)  \
    do {                                  \
        SCOPED_TRACE(describe(datagram)); \
        (client).says(datagram);          \
        hears_nothing(client);            \
    } while (false)

TEST_P(S5_2_Frame, a_ShortFormIsTaken) {
    Client& robot = connected();
    robot.says({0x02, 0x16});
    robot.hears({0x02, 0x17});
}

TEST_P(S5_2_Frame, b_LongFormIsTakenForShortMessages) {  // 5.2.1c
    Client& robot = client();
    robot.says(Body{}.u8(clean).u8(1).u16(0).text(robot.id).in_long_form(Msg::connect));
    robot.hears(connack(accepted));
    robot.says({0x01, 0x00, 0x04, 0x16});
    robot.hears(pingresp());  // the answer has the short form: it fits
}

TEST_P(S5_2_Frame, b_AllFieldsOfALongFormMoveByTwo) {
    Client& robot = connected();
    robot.says(Body{}.u16(0).u16(0x0203).text(topic()).in_long_form(Msg::register_));
    const Octets answer = robot.next();
    ASSERT_EQ(answer.size(), 7u);
    const unsigned id = static_cast<unsigned>(answer[2] << 8U | answer[3]);
    EXPECT_EQ(answer, regack(id, 0x0203, accepted));
    robot.says(Body{}.u8(qos1).u16(id).u16(0x0405).text("x").in_long_form(Msg::publish));
    robot.hears(puback(id, 0x0405));
}

TEST_P(S5_2_Frame, c_ShortFormIsSentUpTo255Octets) {
    Client& robot = connected();
    const unsigned id = robot.subscribes(topic());
    const std::string data(248, 'x');
    robot.publishes(id, data);
    const Octets heard = robot.next();
    ASSERT_EQ(heard.size(), 255u);
    EXPECT_EQ(heard, publish(no_flags, id, 0, data));
    EXPECT_EQ(heard[0], 255);
}

TEST_P(S5_2_Frame, c_LongFormIsSentFrom256Octets) {
    Client& robot = connected();
    const unsigned id = robot.subscribes(topic());
    const std::string data(249, 'x');
    robot.publishes(id, data);
    const Octets heard = robot.next();
    EXPECT_EQ(heard, publish(no_flags, id, 0, data));
    EXPECT_EQ(heard[0], 0x01);
}

TEST_P(S5_2_Frame, d_OneDatagramCarriesAsMuchAsUdpDoes) {
    Client& robot = connected();
    const unsigned id = robot.subscribes(topic(), 1);
    const std::string data(65'498, 'x');  // 65507 octets with its header: all of UDP over IPv4
    robot.publishes(id, data, 1);
    robot.takes(qos1, id, data);
}

TEST_P(S5_2_Frame, d_DataAreAnyOctets) {  // 5.3.2
    Client& robot = connected();
    const unsigned id = robot.subscribes(topic());
    std::string data;
    for (int octet = 0; octet < 256; ++octet) data += static_cast<char>(octet);
    robot.publishes(id, data);
    robot.hears_publish(no_flags, id, data);
}

TEST_P(S5_2_Frame, g3_A255OctetMessageInPahosLongFormIsTaken) {
    Client& robot = connected();
    const unsigned id = robot.subscribes(topic());
    const std::string data(248, 'x');
    Octets datagram = Body{}.u8(0).u16(id).u16(0).text(data).in_long_form(Msg::publish);
    ASSERT_EQ(datagram.size(), 257u);
    datagram[1] = 0x00;  // Paho's MQTTSNPacket counts 255 of its 257 octets
    datagram[2] = 0xFF;
    robot.says(datagram);
    robot.hears_publish(no_flags, id, data);
}

TEST_P(S5_2_Frame, LengthZeroIsNoMessage) {
    Client& robot = connected();
    EXPECT_DROPPED(robot, Octets({0x00, 0x16}));
    EXPECT_DROPPED(robot, Octets({0x00}));
}

TEST_P(S5_2_Frame, AnEmptyDatagramIsNoMessage) {
    Client& robot = connected();
    EXPECT_DROPPED(robot, Octets{});
}

TEST_P(S5_2_Frame, LongFormUnderFourOctetsIsNoMessage) {
    Client& robot = connected();
    EXPECT_DROPPED(robot, Octets({0x01}));
    EXPECT_DROPPED(robot, Octets({0x01, 0x00}));
    EXPECT_DROPPED(robot, Octets({0x01, 0x00, 0x03}));
    EXPECT_DROPPED(robot, Octets({0x01, 0x00, 0x03, 0x16}));
}

TEST_P(S5_2_Frame, g3_LengthBeyondTheDatagramIsNoMessage) {
    Client& robot = connected();
    EXPECT_DROPPED(robot, Octets({0x03, 0x16}));
    EXPECT_DROPPED(robot, Octets({0xFF, 0x16}));
    EXPECT_DROPPED(robot, Octets({0x01, 0xFF, 0xFF, 0x16}));
}

TEST_P(S5_2_Frame, g3_LengthShortOfTheDatagramIsNoMessage) {
    Client& robot = connected();
    EXPECT_DROPPED(robot, Octets({0x02, 0x16, 0x02, 0x16}));
    EXPECT_DROPPED(robot, Octets({0x01, 0x00, 0x04, 0x16, 0x00}));
}

TEST_P(S5_2_Frame, ReservedTypesAreNoMessages) {  // 5.2.2
    Client& robot = connected();
    for (const int type : {0x03, 0x11, 0x19, 0x1E, 0x1F, 0x7F, 0x80, 0xFD, 0xFF}) {
        const auto octet = static_cast<std::uint8_t>(type);
        EXPECT_DROPPED(robot, Octets({0x02, octet}));
        EXPECT_DROPPED(robot, Octets({0x06, octet, 0x00, 0x01, 0x00, 0x01}));
    }
}

TEST_P(S5_2_Frame, EachRequestThatIsTooShortIsNoMessage) {  // 5.4
    Client& robot = connected();
    const unsigned id = robot.registers(topic());
    const std::vector<Octets> shortest{searchgw(0),
                                       connect("", clean),
                                       willmsg(""),
                                       register_topic(0, 1, "a"),
                                       regack(1, 1, accepted),
                                       publish(qos1, id, 9, ""),
                                       puback(1, 1),
                                       pubrec(1),
                                       pubrel(1),
                                       pubcomp(1),
                                       subscribe(qos1, 1, "a"),
                                       unsubscribe(no_flags, 1, "a"),
                                       subscribe_id(qos1, 1, 7),
                                       disconnect_for(1)};
    for (const Octets& message : shortest) {
        for (std::size_t size = 2; size < message.size(); ++size) {
            if (message[1] == 0x18 && size == 2) continue;  // a plain DISCONNECT
            if (message[1] == 0x0A && size == 6) continue;  // an empty name is refused (6.5b)
            Octets truncated(message.begin(), message.begin() + static_cast<std::ptrdiff_t>(size));
            truncated[0] = static_cast<std::uint8_t>(size);
            EXPECT_DROPPED(robot, truncated);
        }
    }
}

TEST_P(S5_2_Frame, EachMessageOfFixedSizeThatIsTooLongIsNoMessage) {  // 5.4
    Client& robot = connected();
    const unsigned id = robot.registers(topic());
    const std::vector<Octets> all{
        searchgw(0), regack(1, 1, accepted),   puback(id, 1), pubrec(1),        pubrel(1),
        pubcomp(1),  subscribe_id(qos1, 1, 7), pingresp(),    disconnect_for(1)};
    for (Octets message : all) {
        message.push_back(0x00);
        ++message[0];
        EXPECT_DROPPED(robot, message);
    }
}

TEST_P(S5_2_Frame, MessagesThatOnlyBrokersSendAreIgnored) {
    Client& robot = connected();
    EXPECT_DROPPED(robot, connack(accepted));
    EXPECT_DROPPED(robot, willtopicreq());
    EXPECT_DROPPED(robot, willmsgreq());
    EXPECT_DROPPED(robot, suback(no_flags, 1, 1));
    EXPECT_DROPPED(robot, unsuback(1));
    EXPECT_DROPPED(robot, willtopicresp(accepted));
    EXPECT_DROPPED(robot, willmsgresp(accepted));
}

// Not where wildcards are tried: some of the noise is retained.
CONFORMANCE_SUITE(S5_2_Noise, ImpatientSuite);

TEST_P(S5_2_Noise, RandomOctetsDoNoHarm) {
    Client& robot = connected();
    Client& noisy = client();
    std::mt19937 random{20'131'114};  // the same in every run
    for (int i = 0; i < 3'000; ++i) {
        Octets datagram(random() % 40);
        for (auto& octet : datagram) octet = static_cast<std::uint8_t>(random());
        if (datagram.size() > 1) {
            if (random() % 4 != 0) datagram[0] = static_cast<std::uint8_t>(datagram.size());
            if (random() % 4 != 0) datagram[1] = static_cast<std::uint8_t>(random() % 0x1E);
        }
        noisy.says(datagram);
        if (i % 100 == 0) settle();  // no more than a socket's buffer takes
    }
    robot.says(pingreq());
    robot.hears(pingresp());
}

CONFORMANCE_SUITE(S5_3_Flags, PatientSuite);

TEST_P(S5_3_Flags, s4_UnusedBitsOfConnectAreIgnored) {
    Client& robot = client();
    robot.says(connect(robot.id, dup | qos2 | retain | reserved_type | clean));
    robot.hears(connack(accepted));
}

TEST_P(S5_3_Flags, s4_UnusedBitsOfPublishAreIgnored) {
    Client& robot = connected();
    const unsigned id = robot.subscribes(topic());
    robot.says(publish(with_will | clean, id, 0, "x"));
    robot.hears_publish(no_flags, id, "x");
}

TEST_P(S5_3_Flags, s4_UnusedBitsOfSubscribeAndUnsubscribeAreIgnored) {
    Client& robot = connected();
    robot.says(subscribe(qos1 | retain | with_will | clean, 5, topic()));
    const Octets answer = robot.next();
    ASSERT_EQ(answer.size(), 8u);
    EXPECT_EQ(answer[2], qos1);  // the granted QoS and nothing else
    EXPECT_EQ(answer[7], accepted);
    robot.says(unsubscribe(dup | qos2 | retain | with_will | clean, 6, topic()));
    robot.hears(unsuback(6));
}

TEST_P(S5_3_Flags, s7_BothSidesNumberTheirOwnRequests) {
    Client& robot = connected();
    const unsigned id = robot.subscribes(topic(), 1);
    robot.says(publish(qos1, id, 1, "x"));  // B numbers from 1 as well
    robot.hears(puback(id, 1));
    const unsigned of_the_broker = robot.hears_publish(qos1, id, "x");
    robot.says(publish(qos1, id, of_the_broker, "y"));
    robot.hears(puback(id, of_the_broker));
    robot.says(puback(id, of_the_broker));
    robot.takes(qos1, id, "y");
}

TEST_P(S5_3_Flags, s11_ReservedTopicIdsAreNeverAccepted) {  // 5.3.11a
    Client& robot = connected();
    for (const unsigned id : {0x0000U, 0xFFFFU}) {
        robot.says(publish(qos1, id, 9, "x"));
        robot.hears(puback(id, 9, invalid_topic_id));
        robot.says(publish(qos1 | predefined, id, 10, "x"));
        robot.hears(puback(id, 10, invalid_topic_id));
    }
}

TEST_P(S5_3_Flags, s4_TheSameBitsNameOtherTopicsInEachNumberSpace) {  // 5.3.4a
    Client& robot = connected();
    const unsigned normal = robot.subscribes(topic());
    robot.says(publish(qos1 | short_name, normal, 9, "not for it"));
    (void)robot.next();  // whatever is said of such a name
    robot.says(publish(predefined, normal, 0, "not for it"));
    robot.publishes(normal, "x");
    Octets heard = robot.next();
    if (!heard.empty() && heard[1] == 0x0D) heard = robot.next();  // no such predefined id
    EXPECT_EQ(heard, publish(no_flags, normal, 0, "x"));
}

}  // namespace
}  // namespace romano::conformance::frame_test
