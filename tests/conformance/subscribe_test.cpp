// Section 6.9: SUBSCRIBE and UNSUBSCRIBE, and which names a filter matches (MQTT 3.1.1
// section 4.7).

#include "tests/conformance/suite.h"

namespace romano::conformance::subscribe_test {
namespace {

CONFORMANCE_SUITE(S6_9_Subscribe, PatientSuite);

TEST_P(S6_9_Subscribe, a_APlainNameIsAnsweredWithItsId) {
    Client& robot = connected();
    const unsigned id = robot.subscribes(topic());
    EXPECT_NE(id, 0u);
    robot.publishes(id, "x", 1);
    robot.hears_publish(no_flags, id, "x");
}

TEST_P(S6_9_Subscribe, a_TheQosThatIsAskedForIsGranted) {
    Client& robot = connected();
    for (int qos = 0; qos <= 2; ++qos) robot.subscribes(topic(std::to_string(qos)), qos);
}

TEST_P(S6_9_Subscribe, b_AFilterWithWildcardsIsAnsweredWithId0) {
    Client& robot = connected();
    EXPECT_EQ(robot.subscribes(topic("+")), 0);
    EXPECT_EQ(robot.subscribes(topic("#")), 0);
}

TEST_P(S6_9_Subscribe, c_APredefinedIdIsAnsweredWithItself) {
    Client& robot = connected();
    robot.says(subscribe_id(qos1, 5, agreement().predefined_id));
    robot.hears(suback(qos1, agreement().predefined_id, 5));
}

TEST_P(S6_9_Subscribe, c_AnUnknownPredefinedIdIsRefused) {
    Client& robot = connected();
    robot.says(subscribe_id(no_flags, 5, 0x7777));
    robot.hears(suback(no_flags, 0x7777, 5, invalid_topic_id));
}

TEST_P(S6_9_Subscribe, d_AShortNameIsAnsweredWithItsOctets) {  // G17
    Client& robot = connected();
    robot.says(subscribe(qos1 | short_name, 5, "s1"));
    robot.hears(suback(qos1, short_topic("s1"), 5));
}

TEST_P(S6_9_Subscribe, g18_OddShortNamesAreTakenAsFilters) {
    Client& robot = connected();
    robot.says(subscribe(short_name, 5, "/#"));  // mqtt-sn-sub sends it so
    robot.hears(suback(no_flags, 0, 5));
    Client& publisher = connected();
    const unsigned id = publisher.registers("/" + topic());
    publisher.publishes(id, "x");
    robot.takes(no_flags, robot.hears_register("/" + topic()).topic_id, "x");
}

TEST_P(S6_9_Subscribe, e_QosMinus1IsRefused) {
    Client& robot = connected();
    robot.says(subscribe(qos_minus_1, 5, topic()));
    robot.hears(suback(no_flags, 0, 5, not_supported));
}

TEST_P(S6_9_Subscribe, e_TheReservedTypeOfTopicIdIsRefused) {
    Client& robot = connected();
    robot.says(subscribe(reserved_type, 5, topic()));
    robot.hears(suback(no_flags, 0, 5, not_supported));
}

TEST_P(S6_9_Subscribe, e_FiltersThatAreNoFiltersAreRefused) {  // G26
    Client& robot = connected();
    for (const std::string filter :
         {"a#", "#a", "#/a", "a/#/b", "a+", "+a", "a/b+/c", "++", "##", "\xFF", "a\xC3"}) {
        robot.says(subscribe(no_flags, 5, filter));
        robot.hears(suback(no_flags, 0, 5, not_supported));
    }
}

TEST_P(S6_9_Subscribe, AFilterOfThirtyThousandLevelsDoesNoHarm) {
    Client& robot = connected();
    std::string filter = "+";
    while (filter.size() < 60'000) filter += "/+";
    robot.says(subscribe(no_flags, 5, filter));
    EXPECT_EQ(robot.next().size(), 8u);  // taken or refused
    std::string name = topic();
    while (name.size() < 60'000) name += "/a";
    robot.publishes(robot.registers(name), "x", 1);
}

TEST_P(S6_9_Subscribe, MsgIdIsCopiedAsItIs) {  // G23
    Client& robot = connected();
    const unsigned id = robot.subscribes(topic());
    for (const unsigned msg_id : {0U, 1U, 0x8000U, 0xFFFFU}) {
        robot.says(subscribe(no_flags, msg_id, topic()));
        robot.hears(suback(no_flags, id, msg_id));
    }
}

TEST_P(S6_9_Subscribe, ARepetitionIsAnsweredAlike) {
    Client& robot = connected();
    robot.says(subscribe(qos1, 5, topic()));
    const Octets answer = robot.next();
    robot.says(subscribe(dup | qos1, 5, topic()));
    EXPECT_EQ(robot.next(), answer);
    robot.publishes(robot.registers(topic()), "x");
    (void)robot.next();
    hears_nothing(robot);  // one subscription: one copy
}

TEST_P(S6_9_Subscribe, f_TheSameFilterAgainReplacesTheQos) {
    Client& robot = connected();
    const unsigned id = robot.subscribes(topic(), 2);
    robot.subscribes(topic(), 0);
    Client& publisher = connected();
    publisher.publishes(publisher.registers(topic()), "x", 2);
    robot.hears_publish(no_flags, id, "x");
    hears_nothing(robot);
}

TEST_P(S6_9_Subscribe, f_TheSameFilterAgainBringsTheRetainedMessageAgain) {
    Client& robot = connected();
    retains(robot, topic(), "kept");
    for (int i = 0; i < 2; ++i) {
        const unsigned id = robot.subscribes(topic());
        robot.hears_publish(retain, id, "kept");
    }
}

TEST_P(S6_9_Subscribe, OverlappingFiltersBringOneCopyAtTheHighestQos) {  // MQTT 3.3.5-1
    Client& robot = connected();
    const unsigned id = robot.subscribes(topic("a"), 0);
    robot.subscribes(topic("+"), 2);
    robot.subscribes(topic("#"), 1);
    Client& publisher = connected();
    publisher.publishes(publisher.registers(topic("a")), "x", 2);
    robot.takes(qos2, id, "x");
    hears_nothing(robot);
}

CONFORMANCE_SUITE(S6_9_Unsubscribe, PatientSuite);

TEST_P(S6_9_Unsubscribe, h_EndsTheSubscription) {
    Client& robot = connected();
    const unsigned id = robot.subscribes(topic());
    robot.says(unsubscribe(no_flags, 9, topic()));
    robot.hears({0x04, 0x15, 0x00, 0x09});
    robot.publishes(id, "x", 1);
    hears_nothing(robot);
}

TEST_P(S6_9_Unsubscribe, h_IsAnsweredAlsoWithoutASubscription) {
    Client& robot = connected();
    robot.says(unsubscribe(no_flags, 9, topic()));
    robot.hears(unsuback(9));
    robot.says(unsubscribe(no_flags, 9, "no/filter#"));
    robot.hears(unsuback(9));
    robot.says(Body{}.u8(predefined).u16(9).u16(0x7777).as(Msg::unsubscribe));
    robot.hears(unsuback(9));
}

TEST_P(S6_9_Unsubscribe, h_FiltersAreComparedAsText) {
    Client& robot = connected();
    robot.subscribes(topic("+"));
    const unsigned id = robot.registers(topic("a"));
    robot.says(unsubscribe(no_flags, 9, topic("a")));
    robot.hears(unsuback(9));
    robot.publishes(id, "x");
    robot.hears_publish(no_flags, id, "x");
    robot.says(unsubscribe(no_flags, 10, topic("+")));
    robot.hears(unsuback(10));
    robot.publishes(id, "y");
    hears_nothing(robot);
}

TEST_P(S6_9_Unsubscribe, h_TopicIdsStayValidForPublishing) {
    Client& robot = connected();
    const unsigned id = robot.subscribes(topic());
    robot.says(unsubscribe(no_flags, 9, topic()));
    robot.hears(unsuback(9));
    robot.publishes(id, "x", 2);
    EXPECT_EQ(robot.subscribes(topic()), id);
}

TEST_P(S6_9_Unsubscribe, PredefinedIdsAndShortNames) {
    Client& robot = connected();
    const unsigned id = agreement().predefined_id;
    robot.says(subscribe_id(no_flags, 5, id));
    robot.hears(suback(no_flags, id, 5));
    robot.says(subscribe(short_name, 6, "u1"));
    robot.hears(suback(no_flags, short_topic("u1"), 6));
    robot.says(Body{}.u8(predefined).u16(7).u16(id).as(Msg::unsubscribe));
    robot.hears(unsuback(7));
    robot.says(unsubscribe(short_name, 8, "u1"));
    robot.hears(unsuback(8));
    robot.publishes(id, "x", 1, predefined);
    robot.publishes(short_topic("u1"), "x", 1, short_name);
    hears_nothing(robot);
}

TEST_P(S6_9_Unsubscribe, ADeliveryUnderWayEndsInOrder) {
    Client& robot = connected();
    const unsigned id = robot.subscribes(topic(), 2);
    Client& publisher = connected();
    publisher.publishes(publisher.registers(topic()), "x", 2);
    const unsigned msg_id = robot.hears_publish(qos2, id, "x");
    robot.says(unsubscribe(no_flags, 9, topic()));
    robot.hears(unsuback(9));
    robot.says(pubrec(msg_id));
    robot.hears(pubrel(msg_id));
    robot.says(pubcomp(msg_id));
    hears_nothing(robot);
}

struct Match {
    std::string filter;
    std::string name;
    bool matches;
};

/// Filters and names stand behind a root of their own, so that no other case meets them.
class Matching : public PatientSuite {
protected:
    void expect(const std::vector<Match>& all) {
        Client& publisher = connected();
        for (const Match& one : all) {
            SCOPED_TRACE(one.filter + (one.matches ? " matches " : " does not match ") + one.name);
            Client& robot = connected();
            unsigned id = robot.subscribes(topic(one.filter));
            publisher.publishes(publisher.registers(topic(one.name)), "x");
            if (one.matches) {
                if (id == 0) id = robot.hears_register(topic(one.name)).topic_id;
                robot.hears_publish(no_flags, id, "x");
            }
            hears_nothing(robot);
            robot.disconnects();
        }
    }
};

CONFORMANCE_SUITE(S6_9_Wildcards, Matching);

TEST_P(S6_9_Wildcards, PlusFillsOneWholeLevel) {  // MQTT 4.7.1-3
    expect({{"+", "a", true},
            {"+", "a/b", false},
            {"a/+", "a/b", true},
            {"a/+", "a", false},
            {"a/+", "a/b/c", false},
            {"+/b", "a/b", true},
            {"a/+/c", "a/b/c", true},
            {"a/+/c", "a/b/d", false},
            {"+/+", "a/b", true},
            {"+/+", "a", false}});
}

TEST_P(S6_9_Wildcards, HashFillsAllLevelsAndTheParent) {  // MQTT 4.7.1-2
    expect({{"#", "a", true},
            {"#", "a/b/c", true},
            {"a/#", "a/b", true},
            {"a/#", "a/b/c", true},
            {"a/#", "a", true},
            {"a/#", "ab", false},
            {"a/#", "b", false},
            {"+/#", "a", true},
            {"a/+/#", "a/b", true},
            {"a/+/#", "a", false}});
}

TEST_P(S6_9_Wildcards, EmptyLevelsCount) {  // MQTT 4.7.3
    expect({{"+", "", true},
            {"a/+", "a/", true},
            {"+/b", "/b", true},
            {"a//b", "a//b", true},
            {"a/+/b", "a//b", true},
            {"a/b", "a//b", false},
            {"a/", "a", false},
            {"a/#", "a//", true}});
}

TEST_P(S6_9_Wildcards, NamesWithoutWildcardsMatchThemselvesAlone) {
    expect({{"a", "a", true}, {"a", "A", false}, {"a", "b", false}, {"a", "a/", false}});
}

TEST_P(S6_9_Wildcards, AFilterThatBeginsWithOneMatchesNoNameThatBeginsWithADollar) {  // 4.7.2-1
    Client& robot = connected();
    robot.subscribes("+/brokers/+");
    hears_nothing(robot);
    robot.says(subscribe(no_flags, 5, "#"));
    robot.hears(suback(no_flags, 0, 5));
    hears_nothing(robot);  // though romano-broker retains messages under $SYS
}

CONFORMANCE_SUITE(Retained, PatientSuite);

TEST_P(Retained, ComesAfterSubackWithRetainSet) {  // MQTT 3.3.1-8, G12
    Client& robot = connected();
    retains(robot, topic(), "kept", 1);
    Client& late = connected();
    const unsigned id = late.subscribes(topic(), 1);
    late.takes(qos1 | retain, id, "kept");
}

TEST_P(Retained, LiveMessagesHaveRetainUnset) {  // MQTT 3.3.1-9
    Client& watcher = connected();
    const unsigned id = watcher.subscribes(topic());
    Client& robot = connected();
    retains(robot, topic(), "kept");
    watcher.hears_publish(no_flags, id, "kept");
}

TEST_P(Retained, TheLastMessageIsKept) {
    Client& robot = connected();
    retains(robot, topic(), "1");
    retains(robot, topic(), "2", 2);
    const unsigned id = robot.subscribes(topic());
    robot.hears_publish(retain, id, "2");
    hears_nothing(robot);
}

TEST_P(Retained, AnUnretainedMessageDoesNotReplaceIt) {
    Client& robot = connected();
    retains(robot, topic(), "kept");
    robot.publishes(robot.registers(topic()), "passing");
    const unsigned id = robot.subscribes(topic());
    robot.hears_publish(retain, id, "kept");
}

TEST_P(Retained, AnEmptyMessageDeletesItAndIsDeliveredLive) {  // MQTT 3.3.1-10
    Client& watcher = connected();
    const unsigned id = watcher.subscribes(topic());
    Client& robot = connected();
    retains(robot, topic(), "kept");
    watcher.hears_publish(no_flags, id, "kept");
    robot.publishes(robot.registers(topic()), "", 1, retain);
    watcher.hears_publish(no_flags, id, "");
    robot.subscribes(topic());
    hears_nothing(robot);
}

TEST_P(Retained, GoesOutAtTheLowerQos) {
    Client& robot = connected();
    for (int kept = 0; kept <= 2; ++kept) {
        retains(robot, topic(std::to_string(kept)), "kept", kept);
        for (int granted = 0; granted <= 2; ++granted) {
            const unsigned id = robot.subscribes(topic(std::to_string(kept)), granted);
            robot.takes(qos_flag(std::min(kept, granted)) | retain, id, "kept");
        }
    }
}

TEST_P(Retained, UnderAWildcardEachNameIsRegisteredFirst) {
    Client& robot = connected();
    retains(robot, topic("a"), "1");
    retains(robot, topic("b"), "2");
    Client& late = connected();
    late.subscribes(topic("+"));
    late.takes(retain, late.hears_register(topic("a")).topic_id, "1");
    late.takes(retain, late.hears_register(topic("b")).topic_id, "2");
}

TEST_P(Retained, MoreThanAQueueHoldsAllCome) {
    constexpr unsigned all = 1'100;  // --max-queued is 1,000
    Client& publisher = connected();
    std::vector<unsigned> ids;
    for (unsigned n = 0; n < all; ++n) {
        ids.push_back(publisher.registers(topic("m/" + std::to_string(n))));
        publisher.publishes(ids.back(), "x", 0, retain);
    }
    settle();
    Client& robot = connected();
    robot.subscribes(topic("m/#"));
    for (unsigned n = 0; n < all; ++n) {
        const Octets told = robot.next();
        ASSERT_GT(told.size(), 6U) << n << " came";
        const unsigned id = unsigned{told[2]} << 8U | told[3];
        robot.says(regack(id, unsigned{told[4]} << 8U | told[5], accepted));
        robot.hears(publish(retain, id, 0, "x"));
    }
    hears_nothing(robot);
    for (const unsigned id : ids) publisher.publishes(id, "", 0, retain);
    publisher.disconnects();
}

TEST_P(Retained, OutlivesItsPublisher) {
    Client& robot = connected();
    retains(robot, topic(), "kept");
    robot.disconnects();
    robot.connects(clean);
    const unsigned id = robot.subscribes(topic());
    robot.hears_publish(retain, id, "kept");
}

TEST_P(Retained, ForPredefinedIdsAndShortNames) {
    Client& robot = connected();
    const unsigned id = agreement().predefined_id;
    robot.publishes(id, "p", 1, predefined | retain);
    forget_retained(agreement().predefined_topic);
    robot.publishes(short_topic("v1"), "s", 1, short_name | retain);
    forget_retained("v1");
    robot.says(subscribe_id(qos1, 5, id));
    robot.hears(suback(qos1, id, 5));
    robot.takes(qos1 | predefined | retain, id, "p");
    robot.says(subscribe(qos1 | short_name, 6, "v1"));
    robot.hears(suback(qos1, short_topic("v1"), 6));
    robot.takes(qos1 | short_name | retain, short_topic("v1"), "s");
}

}  // namespace
}  // namespace romano::conformance::subscribe_test
