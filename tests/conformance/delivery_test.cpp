// Section 6.10: PUBLISH and REGISTER towards the client.

#include <functional>

#include "tests/conformance/suite.h"

namespace romano::conformance::delivery_test {
namespace {

class Delivering : public PatientSuite {
protected:
    /// Somebody publishes this to the case's own topic.
    void publishes(const std::string& data, int qos, const std::string& name = "t") {
        if (publisher_ == nullptr) publisher_ = &connected();
        publisher_->publishes(publisher_->registers(topic(name)), data, qos);
    }

private:
    Client* publisher_ = nullptr;
};

CONFORMANCE_SUITE(S6_10_Delivery, Delivering);

TEST_P(S6_10_Delivery, c_GoesOutAtTheLowerOfPublishedAndGranted) {
    for (int granted = 0; granted <= 2; ++granted) {
        Client& robot = connected();
        const unsigned id = robot.subscribes(topic(), granted);
        for (int published = 0; published <= 2; ++published) {
            publishes("x", published);
            robot.takes(qos_flag(std::min(published, granted)), id, "x");
        }
        robot.disconnects();
    }
}

TEST_P(S6_10_Delivery, c_MessagesOfATopicKeepTheirOrder) {
    Client& robot = connected();
    const unsigned id = robot.subscribes(topic(), 1);
    for (int n = 0; n < 20; ++n) publishes(std::to_string(n), 1);
    for (int n = 0; n < 20; ++n) robot.takes(qos1, id, std::to_string(n));
}

TEST_P(S6_10_Delivery, c_EverySubscriberGetsItsCopy) {
    std::vector<std::pair<Client*, unsigned>> robots;
    for (int n = 0; n < 30; ++n) {
        Client& robot = connected();
        if (n % 2 == 1) robot.registers(topic("other"));  // so that ids differ
        robots.emplace_back(&robot, robot.subscribes(topic(), n % 3));
    }
    publishes("x", 2);
    for (std::size_t n = 0; n < robots.size(); ++n) {
        robots[n].first->takes(qos_flag(static_cast<int>(n % 3)), robots[n].second, "x");
    }
}

TEST_P(S6_10_Delivery, d_OneExchangeIsOpenAtATime) {  // G24
    Client& robot = connected();
    const unsigned id = robot.subscribes(topic(), 2);
    publishes("1", 1);
    publishes("2", 2);
    const unsigned first = robot.hears_publish(qos1, id, "1");
    hears_nothing(robot);
    robot.says(puback(id, first));
    const unsigned second = robot.hears_publish(qos2, id, "2");
    EXPECT_NE(second, first);
    robot.says(pubrec(second));
    robot.hears(pubrel(second));
    robot.says(pubcomp(second));
}

TEST_P(S6_10_Delivery, d_PubackOfAnotherMsgIdEndsNothing) {
    Client& robot = connected();
    const unsigned id = robot.subscribes(topic(), 1);
    publishes("1", 1);
    publishes("2", 1);
    const unsigned first = robot.hears_publish(qos1, id, "1");
    robot.says(puback(id, first + 1));
    hears_nothing(robot);
    robot.says(puback(id, first));
    robot.takes(qos1, id, "2");
}

TEST_P(S6_10_Delivery, d_Puback0DoesNotEndQos2) {  // 6.6a
    Client& robot = connected();
    const unsigned id = robot.subscribes(topic(), 2);
    publishes("1", 2);
    const unsigned msg_id = robot.hears_publish(qos2, id, "1");
    robot.says(puback(id, msg_id));
    hears_nothing(robot);
    robot.says(pubrec(msg_id));
    robot.hears(pubrel(msg_id));
    robot.says(pubcomp(msg_id));
}

TEST_P(S6_10_Delivery, d_PubcompBeforePubrecEndsNothing) {
    Client& robot = connected();
    const unsigned id = robot.subscribes(topic(), 2);
    publishes("1", 2);
    publishes("2", 2);
    const unsigned msg_id = robot.hears_publish(qos2, id, "1");
    robot.says(pubcomp(msg_id));
    hears_nothing(robot);
    robot.says(pubrec(msg_id));
    robot.hears(pubrel(msg_id));
    robot.says(pubcomp(msg_id));
    robot.takes(qos2, id, "2");
}

// A client that waits for PUBREL holds the message back, whatever the broker remembers of it.
TEST_P(S6_10_Delivery, d_APubrecOfNothingIsAnsweredByPubrel) {
    Client& robot = connected();
    robot.says(pubrec(999));
    robot.hears(pubrel(999));
}

TEST_P(S6_10_Delivery, d_ARepeatedPubrecIsAnsweredAgain) {
    Client& robot = connected();
    const unsigned id = robot.subscribes(topic(), 2);
    publishes("1", 2);
    const unsigned msg_id = robot.hears_publish(qos2, id, "1");
    for (int i = 0; i < 2; ++i) {
        robot.says(pubrec(msg_id));
        robot.hears(pubrel(msg_id));
    }
    robot.says(pubcomp(msg_id));
    robot.says(pubrec(msg_id));  // it was finished here: the client may finish it too
    robot.hears(pubrel(msg_id));
}

TEST_P(S6_10_Delivery, e_Puback2BringsRegisterAndThePublishAgain) {  // G21
    Client& robot = connected();
    const unsigned id = robot.subscribes(topic(), 1);
    publishes("x", 1);
    const unsigned first = robot.hears_publish(qos1, id, "x");
    robot.says(puback(id, first, invalid_topic_id));
    EXPECT_EQ(robot.hears_register(topic()).topic_id, id);
    const unsigned second = robot.hears_publish(qos1, id, "x");  // DUP 0
    EXPECT_NE(second, first);
    robot.says(puback(id, second));
    hears_nothing(robot);
}

TEST_P(S6_10_Delivery, e_Puback2TwiceDropsTheMessage) {
    Client& robot = connected();
    const unsigned id = robot.subscribes(topic(), 1);
    publishes("1", 1);
    publishes("2", 1);
    robot.says(puback(id, robot.hears_publish(qos1, id, "1"), invalid_topic_id));
    robot.hears_register(topic());
    robot.says(puback(id, robot.hears_publish(qos1, id, "1"), invalid_topic_id));
    // The next one goes on; whether its id is told once more is the broker's affair.
    Octets heard = robot.next();
    if (heard.size() > 1 && heard[1] == 0x0A) {
        robot.says(regack(id, static_cast<unsigned>(heard[4] << 8U | heard[5]), accepted));
        heard = robot.next();
    }
    ASSERT_EQ(heard.size(), 8u) << describe(heard);
    EXPECT_EQ(heard[7], '2');
}

TEST_P(S6_10_Delivery, e_Puback2AtQos0ForgetsThatTheIdIsKnown) {  // G21
    Client& robot = connected();
    const unsigned id = robot.subscribes(topic(), 0);
    publishes("x", 0);
    robot.hears_publish(no_flags, id, "x");
    robot.says(puback(id, 0, invalid_topic_id));
    publishes("y", 0);
    EXPECT_EQ(robot.hears_register(topic()).topic_id, id);
    robot.hears_publish(no_flags, id, "y");
}

TEST_P(S6_10_Delivery, g25_Puback3BringsAPlainerMessageOnce) {
    Client& robot = connected();
    const unsigned id = robot.subscribes(topic(), 2);
    publishes("x", 2);
    const unsigned first = robot.hears_publish(qos2, id, "x");
    robot.says(puback(id, first, not_supported));
    const unsigned second = robot.hears_publish(qos1, id, "x");  // emcute knows QoS 1 at most
    EXPECT_NE(second, first);
    robot.says(puback(id, second, not_supported));
    hears_nothing(robot);  // refused again: dropped
}

TEST_P(S6_10_Delivery, g25_Puback3ToARetainedMessageBringsItUnretained) {
    Client& publisher = connected();
    retains(publisher, topic(), "kept", 1);
    Client& robot = connected();
    const unsigned id = robot.subscribes(topic(), 1);
    const unsigned first = robot.hears_publish(qos1 | retain, id, "kept");
    robot.says(puback(id, first, not_supported));
    robot.takes(qos1, id, "kept");
}

TEST_P(S6_10_Delivery, AcknowledgementsOfNothingAreIgnored) {
    Client& robot = connected();
    robot.says(puback(1, 9));
    robot.says(pubcomp(9));
    robot.says(regack(1, 9, accepted));
    robot.says(pingresp());
    hears_nothing(robot);
}

CONFORMANCE_SUITE(S6_10_Register, Delivering);

TEST_P(S6_10_Register, a_ComesBeforeTheFirstMessageOfAWildcard) {
    Client& robot = connected();
    robot.subscribes(topic("+"), 1);
    publishes("x", 1);
    const auto told = robot.hears_register(topic("t"), false);
    hears_nothing(robot);  // waits for REGACK
    robot.says(regack(told.topic_id, told.msg_id, accepted));
    robot.takes(qos1, told.topic_id, "x");
}

TEST_P(S6_10_Register, a_ComesOnceForAName) {
    Client& robot = connected();
    robot.subscribes(topic("+"));
    publishes("1", 0);
    const unsigned id = robot.hears_register(topic("t")).topic_id;
    robot.takes(no_flags, id, "1");
    publishes("2", 0);
    robot.takes(no_flags, id, "2");
    EXPECT_EQ(robot.registers(topic("t")), id);  // one name, one id
}

TEST_P(S6_10_Register, a_LaterMessagesWaitBehindItInOrder) {
    Client& robot = connected();
    robot.subscribes(topic("+"), 1);
    publishes("1", 0);
    publishes("2", 1);
    publishes("3", 0);
    publishes("4", 1, "u");
    const unsigned t = robot.hears_register(topic("t")).topic_id;
    robot.takes(no_flags, t, "1");
    robot.takes(qos1, t, "2");
    robot.takes(no_flags, t, "3");
    robot.takes(qos1, robot.hears_register(topic("u")).topic_id, "4");
}

TEST_P(S6_10_Register, a_ARegackOfAnotherMsgIdIsNoAnswer) {
    Client& robot = connected();
    robot.subscribes(topic("+"));
    publishes("x", 0);
    const auto told = robot.hears_register(topic("t"), false);
    robot.says(regack(told.topic_id, told.msg_id + 1U, accepted));
    hears_nothing(robot);
    robot.says(regack(told.topic_id, told.msg_id, accepted));
    robot.takes(no_flags, told.topic_id, "x");
}

TEST_P(S6_10_Register, a_NamesTheClientRegisteredAreKnown) {
    Client& robot = connected();
    const unsigned id = robot.registers(topic());
    robot.subscribes(topic("+"));
    publishes("x", 0);
    robot.takes(no_flags, id, "x");
}

TEST_P(S6_10_Register, b_ARefusalStopsThatNameAndNoOther) {  // G16
    Client& robot = connected();
    robot.subscribes(topic("+"), 1);
    publishes("1", 1);
    const auto told = robot.hears_register(topic("t"), false);
    robot.says(regack(told.topic_id, told.msg_id, not_supported));
    publishes("2", 1);
    publishes("3", 1, "u");
    robot.takes(qos1, robot.hears_register(topic("u")).topic_id, "3");
    hears_nothing(robot);
}

TEST_P(S6_10_Register, b_AfterARefusalSubscribingBringsTheNameBack) {
    Client& robot = connected();
    robot.subscribes(topic("+"), 1);
    publishes("1", 1);
    const auto told = robot.hears_register(topic("t"), false);
    robot.says(regack(told.topic_id, told.msg_id, invalid_topic_id));
    const unsigned id = robot.subscribes(topic("t"), 1);
    publishes("2", 1);
    robot.takes(qos1, id, "2");
}

TEST_P(S6_10_Register, g17_ATwoOctetNameUnderAWildcardNeedsNone) {
    Client& robot = connected();
    robot.subscribes("+");
    Client& publisher = connected();
    publisher.publishes(short_topic("w1"), "x", 0, short_name);
    robot.hears_publish(short_name, short_topic("w1"), "x");
}

class Retrying : public ImpatientSuite {
protected:
    /// Somebody else publishes this to the case's own topic.
    void publishes(const std::string& data, int qos) {
        if (publisher_ == nullptr) publisher_ = &connected();
        const unsigned id = publisher_->registers(topic());
        publisher_->publishes(id, data, qos);
    }

    /// The client lives, answers nothing that it is asked, and waits for this.
    void keeps_pinging_until(Client& robot, const std::function<bool(const Octets&)>& came) {
        const auto end = std::chrono::steady_clock::now() + 20s;
        while (std::chrono::steady_clock::now() < end) {
            robot.says(pingreq());
            for (Octets heard = robot.next(20ms); !heard.empty(); heard = robot.next(20ms)) {
                if (came(heard)) return;
            }
        }
        ADD_FAILURE() << "it does not come";
    }

private:
    Client* publisher_ = nullptr;
};

CONFORMANCE_SUITE(S6_13_Retries, Retrying);

TEST_P(S6_13_Retries, c_PublishIsRepeatedWithDupAndItsMsgId) {
    for (const int qos : {1, 2}) {
        Client& robot = connected();
        const unsigned id = robot.subscribes(topic(), qos);
        publishes("x", qos);
        const unsigned msg_id = robot.hears_publish(qos_flag(qos), id, "x");
        robot.hears_in_time(publish(dup | qos_flag(qos), id, msg_id, "x"));
        robot.says(qos == 1 ? puback(id, msg_id) : pubrec(msg_id));
        if (qos == 2) robot.hears_in_time(pubrel(msg_id));
        if (qos == 2) robot.says(pubcomp(msg_id));
    }
}

TEST_P(S6_13_Retries, c_PubrelIsRepeated) {
    Client& robot = connected();
    const unsigned id = robot.subscribes(topic(), 2);
    publishes("x", 2);
    const unsigned msg_id = robot.hears_publish(qos2, id, "x");
    robot.says(pubrec(msg_id));
    robot.hears_in_time(pubrel(msg_id));
    robot.hears_in_time(pubrel(msg_id));
    robot.says(pubcomp(msg_id));
}

TEST_P(S6_13_Retries, c_RegisterIsRepeated) {
    Client& robot = connected();
    robot.subscribes(topic("+"));
    publishes("x", 0);
    const auto told = robot.hears_register(topic(), false);
    robot.hears_in_time(register_topic(told.topic_id, told.msg_id, topic()));
    robot.says(regack(told.topic_id, told.msg_id, accepted));
    robot.hears_in_time(publish(no_flags, told.topic_id, 0, "x"));
}

TEST_P(S6_13_Retries, g14_AClientThatIgnoresRegisterGetsItsMessageAllTheSame) {
    Client& robot = connected();
    robot.subscribes(topic("+"));
    publishes("x", 0);
    const auto told = robot.hears_register(topic(), false);
    keeps_pinging_until(robot, [&](const Octets& heard) {
        return heard == publish(no_flags, told.topic_id, 0, "x");
    });
}

TEST_P(S6_13_Retries, g5_AMessageThatALivingClientDoesNotTakeIsDroppedAndTheNextOneGoes) {
    Client& robot = connected();
    const unsigned id = robot.subscribes(topic(), 1);
    publishes("1", 1);
    publishes("2", 1);
    keeps_pinging_until(robot, [&](const Octets& heard) {
        const bool next_one = heard.size() == 8 && heard[1] == 0x0C && heard[7] == '2';
        if (next_one) robot.says(puback(id, static_cast<unsigned>(heard[5] << 8U | heard[6])));
        return next_one;
    });
}

TEST_P(S6_13_Retries, g5_ASilentClientsMessagesWaitUntilItIsHeard) {
    Client& robot = connected();
    const unsigned id = robot.subscribes(topic(), 1);
    publishes("x", 1);
    const unsigned msg_id = robot.hears_publish(qos1, id, "x");
    while (!robot.next(1s).empty()) {  // all repetitions
    }
    robot.says(pingreq());
    robot.hears_in_time(publish(dup | qos1, id, msg_id, "x"));
    robot.says(puback(id, msg_id));
}

}  // namespace
}  // namespace romano::conformance::delivery_test
