// Sessions change their home and their clients do not notice (design: take-over, hand-off).

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "romano/base/random.h"
#include "tests/broker/core/adopting_brokers.h"

namespace romano::broker::adoption_test {
namespace {

using Adoption = AdoptingBrokers;

TEST_F(Adoption, InFlightPublishIsSentAgainWithDupUnderItsMsgId) {
    publisher.connects();
    robot.connects(false);
    robot.subscribes("cmd");
    publisher.publishes(publisher.registers("cmd"), "go", Qos::exactly_once);
    const auto first = robot.hears<Publish>();
    const MsgId msg_id = first.msg_id;
    takes_over(robot);
    const auto again = robot.hears<Publish>();
    EXPECT_TRUE(again.dup);
    EXPECT_EQ(again.msg_id, msg_id);
    EXPECT_EQ(as_text(again.data), "go");
    robot.says(Pubrec{msg_id});
    EXPECT_EQ(robot.hears<Pubrel>().msg_id, msg_id);
    robot.says(Pubcomp{msg_id});
    robot.hears_nothing();
    EXPECT_TRUE(heir.core.image("robot")->deliveries.empty());
}

// P3: its former home may live, and have ended the exchange.
TEST_F(Adoption, WhoWasNotHeardAtTheHeirIsAskedBeforeAMessageIsSentOnceMore) {
    publisher.connects();
    robot.connects(false);
    robot.subscribes("cmd", Qos::exactly_once);
    publisher.publishes(publisher.registers("cmd"), "x", Qos::exactly_once);
    const MsgId msg_id = robot.hears<Publish>().msg_id;
    takes_over(robot);
    EXPECT_EQ(robot.hears<Publish>().msg_id, msg_id);
    heir.waits(10s);
    robot.hears<Pingreq>();
    robot.hears_nothing();
    robot.says(Pingresp{});
    const auto again = robot.hears<Publish>();
    EXPECT_TRUE(again.dup);
    EXPECT_EQ(again.msg_id, msg_id);
    heir.waits(10s);
    EXPECT_EQ(robot.hears<Publish>().msg_id, msg_id) << "it was heard here";
}

TEST_F(Adoption, ReleasedQos2GoesOnWithPubrel) {
    publisher.connects();
    robot.connects(false);
    robot.subscribes("cmd");
    publisher.publishes(publisher.registers("cmd"), "go", Qos::exactly_once);
    const MsgId msg_id = robot.hears<Publish>().msg_id;
    robot.says(Pubrec{msg_id});
    takes_over(robot);
    robot.ignores_what_came();  // the old home's PUBREL
    heir.waits(heir.core.next_wakeup() - heir.now);
    EXPECT_EQ(robot.hears<Pubrel>().msg_id, msg_id);
    robot.says(Pubcomp{msg_id});
    robot.hears_nothing();
}

TEST_F(Adoption, RefusedDupFallsBackToANewMsgIdWithoutDup) {  // G25
    publisher.connects();
    robot.connects(false);
    robot.subscribes("cmd", Qos::at_least_once);
    publisher.publishes(publisher.registers("cmd"), "go", Qos::at_least_once);
    const MsgId msg_id = robot.hears<Publish>().msg_id;
    takes_over(robot);
    const auto again = robot.hears<Publish>();
    EXPECT_TRUE(again.dup);
    robot.says(Puback{again.topic, again.msg_id, ReturnCode::not_supported});
    const auto fallback = robot.hears<Publish>();
    EXPECT_FALSE(fallback.dup);
    EXPECT_NE(fallback.msg_id, msg_id);
    robot.says(Puback{fallback.topic, fallback.msg_id, ReturnCode::accepted});
    robot.hears_nothing();
}

TEST_F(Adoption, MissedMessagesAreQueuedInOrderBehindWhatWaits) {
    publisher.connects();
    robot.connects(false);
    robot.subscribes("cmd");
    publisher.publishes(publisher.registers("cmd"), "1", Qos::at_least_once);
    robot.ignores_what_came();
    const LogId peer{broker_id_of("peer"), 1};
    takes_over(robot, {published_at({peer, 5}, "2", Qos::at_least_once),
                       published_at({peer, 9}, "3", Qos::at_least_once)});
    EXPECT_TRUE(robot.hears_publish("1", Qos::at_least_once).dup);
    robot.hears_publish("2", Qos::at_least_once);
    robot.hears_publish("3", Qos::at_least_once);
    robot.hears_nothing();
}

// The next home may hold neither what was missed nor the log that it stands in.
TEST_F(Adoption, ImageForAThirdHomeBringsWhatWasMissed) {
    robot.connects(false);
    robot.subscribes("cmd");
    const LogId dead{broker_id_of("dead"), 1};
    const MessagePtr missed = published_at({dead, 7}, "last words");
    heir.core.on_peer_message(heir.now, missed, heir.actions);
    heir.drain();
    const auto image = heir.core.caught_up(image_of(home, "robot"), {&missed, 1});
    EXPECT_EQ(image.deliveries.back().position, missed->position);

    ScriptedBroker third{options_of("third")};
    EXPECT_TRUE(third.core.adopt(third.now, image, {}, third.actions));
    third.drain();
    robot.moves_to(third);
    robot.hears_publish("last words", Qos::exactly_once);
    third.core.on_peer_message(third.now, missed, third.actions);  // should it come after all
    third.drain();
    robot.hears_nothing();
}

// As when the view changes while the first one is at it.
TEST_F(Adoption, WhatTwoHeirsOfOneDeadHomeBringIsTakenOnce) {
    robot.connects(false);
    robot.subscribes("cmd");
    const auto image = heir.core.caught_up(image_of(home, "robot"), {});
    ScriptedBroker third{options_of("third")};
    EXPECT_TRUE(third.core.adopt(third.now, image, {}, third.actions));
    EXPECT_FALSE(third.core.adopt(third.now, image, {}, third.actions));
    third.drain();
}

// P3: the other copy was left in the log of a dead broker, and a later heir took it up though the
// client had got all that waited there (simulator, faults `relapse`, seed 9974474).
TEST_F(Adoption, WhoKeepsItsOwnCopySaysSoInItsLog) {
    robot.connects(false);
    robot.subscribes("cmd");
    const SessionImage image = heir.core.caught_up(image_of(home, "robot"), {});
    ScriptedBroker third{options_of("third")};
    EXPECT_TRUE(third.core.adopt(third.now, image, {}, third.actions));
    third.drain();
    const Seq before = third.core.last_seq();
    EXPECT_FALSE(third.core.adopt(third.now, image, {}, third.actions));
    EXPECT_EQ(third.core.last_seq(), before + 1);
    third.drain();
    third.expects_mirror_to_agree();
}

/// The old home had begun with messages of a peer that the heir does not hold.
class AdoptionOfTheUnknown : public Adoption {
protected:
    AdoptionOfTheUnknown() {
        robot.connects(false);
        robot.subscribes("cmd");
        comes(home, once);
        begun = robot.hears<Publish>().msg_id;
    }
    static void comes(ScriptedBroker& to, const MessagePtr& message) {
        to.core.on_peer_message(to.now, message, to.actions);
        to.drain();
    }

    const LogId peer{broker_id_of("peer"), 1};
    const MessagePtr once = published_at({peer, 3}, "once");
    const MessagePtr next = published_at({peer, 4}, "next");
    MsgId begun{};
};

// P2, P3: the PUBLISH may not have left, and may have arrived: its id tells the client
// (simulator, faults `starve`, seed 92).
TEST_F(AdoptionOfTheUnknown, WhatMayHaveBeenSentComesAgainUnderItsId) {
    takes_over(robot);
    robot.hears_nothing();
    heir.expects_mirror_to_agree();
    comes(heir, once);
    const auto again = robot.hears_publish("once", Qos::exactly_once);
    EXPECT_EQ(again.msg_id, begun);
    EXPECT_TRUE(again.dup);
    heir.expects_mirror_to_agree();
    comes(heir, next);
    EXPECT_NE(robot.hears_publish("next", Qos::exactly_once).msg_id, begun);
}

TEST_F(AdoptionOfTheUnknown, AlsoBehindAnotherExchangeAndAtTheNextHeir) {
    takes_over(robot);
    const LogId other{broker_id_of("other"), 1};
    comes(heir, published_at({other, 1}, "meanwhile"));
    const MsgId meanwhile = robot.hears<Publish>().msg_id;
    ScriptedBroker third{options_of("third")};
    comes(third, published_at({other, 1}, "meanwhile"));
    comes(third, once);
    SessionImage image = image_of(heir, "robot");
    ASSERT_EQ(image.deliveries.size(), 2U);
    for (Delivery& delivery : image.deliveries) {
        delivery.message = delivery.position == once->position
                               ? once
                               : published_at(delivery.position, "meanwhile");
    }
    EXPECT_TRUE(third.core.adopt(third.now, image, {}, third.actions));
    third.drain();
    robot.moves_to(third);
    std::map<MsgId, bool> dup_by_id;
    for (int i = 0; i < 2; ++i) {
        const auto publish = robot.hears<Publish>();
        dup_by_id[publish.msg_id] = publish.dup;
        robot.says(Pubrec{publish.msg_id});
        robot.says(Pubcomp{robot.hears<Pubrel>().msg_id});
    }
    EXPECT_EQ(dup_by_id, (std::map<MsgId, bool>{{begun, true}, {meanwhile, true}}));
    robot.hears_nothing();
}

TEST_F(AdoptionOfTheUnknown, WhatTheOldHomeHadWorkedThroughIsNotDeliveredAgain) {
    robot.says(Pubrec{begun});
    robot.says(Pubcomp{robot.hears<Pubrel>().msg_id});
    takes_over(robot);
    comes(heir, once);
    robot.hears_nothing();
}

TEST_F(AdoptionOfTheUnknown, WhatTheClientHasIsOnlyReleased) {
    robot.says(Pubrec{begun});
    robot.hears<Pubrel>();
    takes_over(robot);
    EXPECT_EQ(robot.hears<Pubrel>().msg_id, begun);
    robot.says(Pubcomp{begun});
    comes(heir, once);
    comes(heir, next);
    EXPECT_NE(robot.hears_publish("next", Qos::exactly_once).msg_id, begun);
}

// P3: or the next heir would queue once more what this one had queued when it died.
TEST_F(Adoption, TheHeirsLogSaysHowFarTheSessionWasWorkedThrough) {
    robot.connects(false);
    robot.subscribes("cmd");
    const LogId peer{broker_id_of("peer"), 1};
    const MessagePtr missed = published_at({peer, 7}, "once");
    heir.core.on_peer_message(heir.now, missed, heir.actions);  // for none of its own
    heir.drain();
    EXPECT_TRUE(heir.core.adopt(heir.now, image_of(home, "robot"), {missed}, heir.actions));
    heir.drain();
    for (const LogEvent& event : heir.log) heir.mirror.apply(heir.mirror.applied() + 1, event);
    const auto image = *heir.mirror.image("robot");
    EXPECT_EQ(std::ranges::count(image.deliveries, missed->position, &Delivery::position), 1);
    EXPECT_EQ(std::ranges::count(image.worked_through, missed->position), 1);
}

// P2: its writer is out of the heir's sight, and comes back with the message after a heal.
TEST_F(Adoption, AQueuedMessageThatTheHeirDoesNotKnowIsDeliveredWhenItComes) {
    robot.connects(false);
    robot.subscribes("cmd");
    SessionImage image = image_of(home, "robot");
    const LogId peer{broker_id_of("peer"), 1};
    image.deliveries.push_back({.position = {peer, 3}, .message = {}, .qos = Qos::at_least_once});
    image.worked_through = {{peer, 4}};
    EXPECT_TRUE(heir.core.adopt(heir.now, image, {}, heir.actions));
    heir.drain();
    robot.moves_to(heir);
    heir.expects_mirror_to_agree();
    EXPECT_EQ(heir.core.image("robot")->deliveries.size(), 1U) << "the next heir must know of it";
    for (const Seq seq : {3U, 4U}) {
        const MessagePtr message{Message{.topic = "cmd",
                                         .payload = octets_of(std::to_string(seq)),
                                         .qos = Qos::at_least_once,
                                         .position = {peer, seq},
                                         .published_at = {}}};
        heir.core.on_peer_message(heir.now, message, heir.actions);
        heir.drain();
    }
    robot.hears_publish("3", Qos::at_least_once);
    robot.hears_nothing();
    heir.expects_mirror_to_agree();
    EXPECT_TRUE(heir.core.image("robot")->deliveries.empty());
}

TEST_F(Adoption, WhatAForgottenLogStillOwedIsAwaitedNoMore) {  // P8
    robot.connects(false);
    robot.subscribes("cmd");
    SessionImage image = image_of(home, "robot");
    const LogId former{broker_id_of("peer"), 1};
    const LogId present{broker_id_of("peer"), 2};
    image.deliveries.push_back({.position = {former, 3}, .message = {}, .qos = Qos::at_least_once});
    image.deliveries.push_back(
        {.position = {present, 3}, .message = {}, .qos = Qos::at_least_once});
    image.worked_through = {{former, 4}, {present, 4}};
    EXPECT_TRUE(heir.core.adopt(heir.now, image, {}, heir.actions));
    heir.core.forget_logs([&](const LogId& log) { return log == former; }, heir.actions);
    heir.drain();
    const auto left = *heir.core.image("robot");
    ASSERT_EQ(left.deliveries.size(), 1U);
    EXPECT_EQ(left.deliveries[0].position.log, present);
    EXPECT_EQ(std::ranges::count(left.worked_through, former, &LogPosition::log), 0);
    EXPECT_EQ(std::ranges::count(left.worked_through, present, &LogPosition::log), 1);
}

TEST_F(Adoption, TopicIdsAndSubscriptionsGoOn) {
    publisher.connects();
    robot.connects(false);
    const TopicId cmd = robot.subscribes("cmd");
    const TopicId pose = robot.registers("pose");
    takes_over(robot);
    ScriptedClient local{heir, "local"};
    local.connects();
    local.subscribes("pose");
    robot.says(Publish{false, Qos::at_least_once, false, TopicIdType::normal, pose, MsgId{900},
                       as_octets("x")});
    EXPECT_EQ(robot.hears<Puback>().return_code, ReturnCode::accepted);
    local.hears_publish("x", Qos::at_least_once);
    local.publishes(local.registers("cmd"), "go", Qos::at_least_once);
    EXPECT_EQ(robot.hears_publish("go", Qos::at_least_once).topic, cmd);
}

TEST_F(Adoption, Qos2PublishOfTheClientIsNotAcceptedTwice) {  // P3
    robot.connects(false);
    const TopicId pose = robot.registers("pose");
    const Publish publish{false, Qos::exactly_once, false,         TopicIdType::normal,
                          pose,  MsgId{900},        as_octets("x")};
    robot.says(publish);
    EXPECT_EQ(robot.hears<Pubrec>().msg_id, MsgId{900});
    takes_over(robot);
    ScriptedClient local{heir, "local"};
    local.connects();
    local.subscribes("pose");
    robot.says(publish);
    EXPECT_EQ(robot.hears<Pubrec>().msg_id, MsgId{900});
    local.hears_nothing();
    robot.says(Pubrel{MsgId{900}});
    EXPECT_EQ(robot.hears<Pubcomp>().msg_id, MsgId{900});
}

TEST_F(Adoption, EpochRisesWhenTheClientIsHeardAndNotBefore) {
    robot.connects(false);
    takes_over(robot);
    EXPECT_TRUE(heir.core.image("robot")->header.provisional);
    EXPECT_EQ(heir.core.image("robot")->header.epoch, 1u);
    robot.says(Pingreq{});
    robot.hears<Pingresp>();
    EXPECT_FALSE(heir.core.image("robot")->header.provisional);
    EXPECT_EQ(heir.core.image("robot")->header.epoch, 2u);
    heir.expects_mirror_to_agree();
}

TEST_F(Adoption, KeepAliveStartsAgain) {
    robot.connects(true, 10);
    robot.ignores_what_came();
    heir.waits(1h);
    takes_over(robot);
    heir.waits(14s);
    EXPECT_EQ(heir.core.image("robot")->header.state, SessionState::active);
    heir.waits(2s);
    EXPECT_EQ(heir.core.image("robot")->header.state, SessionState::lost);
}

/// Its home was cut off from the heir, and heard more of the client than the heir knows.
class AdoptionOfASleeper : public Adoption {
protected:
    void SetUp() override {
        publisher.connects();
        robot.connects(true, 10);
        robot.subscribes("cmd");
        robot.says(Disconnect{true, 100});
        robot.hears<Disconnect>();
        publisher.publishes(publisher.registers("cmd"), "go", Qos::exactly_once);
        takes_over(robot);
        robot.hears_nothing();
    }
    SessionState state() { return heir.core.image("robot")->header.state; }
};

TEST_F(AdoptionOfASleeper, WhoSpeaksAsTheConnectedDoIsSentWhatWaits) {  // P2
    robot.says(Pubcomp{MsgId{77}});  // answers its former home, where it has connected
    EXPECT_EQ(as_text(robot.hears<Publish>().data), "go");
    EXPECT_EQ(state(), SessionState::active);
    heir.expects_mirror_to_agree();
}

TEST_F(AdoptionOfASleeper, WhoSleepsAfterAllIsNotLostAndGetsItAll) {  // P7
    robot.says(Pubcomp{MsgId{77}});
    robot.ignores_what_came();
    heir.waits(100s);
    EXPECT_EQ(state(), SessionState::active);
    robot.ignores_what_came();
    robot.says(Pingreq{"robot"});
    const auto again = robot.hears<Publish>();
    EXPECT_TRUE(again.dup);
    robot.says(Pubrec{again.msg_id});
    robot.says(Pubcomp{robot.hears<Pubrel>().msg_id});
    robot.hears<Pingresp>();
    EXPECT_EQ(state(), SessionState::asleep);
    heir.expects_mirror_to_agree();
}

TEST_F(AdoptionOfASleeper, WhoFallsSilentIsProbedForItsKeepAliveOnly) {  // 6.11b
    robot.says(Pubcomp{MsgId{77}});
    robot.ignores_what_came();
    heir.waits(140s);
    std::size_t probes = 0;
    while (const MqttsnMessage* message = robot.next()) {
        if (std::holds_alternative<Pingreq>(*message)) ++probes;
    }
    EXPECT_EQ(probes, 1U);  // after 10 s; not once a Tretry for the whole of its sleep
    EXPECT_EQ(state(), SessionState::active);
}

TEST_F(AdoptionOfASleeper, WhoCollectsItsMessagesSleepsOn) {  // 6.14b
    robot.says(Pingreq{"robot"});
    const auto first = robot.hears<Publish>();
    robot.says(Pubrec{first.msg_id});
    robot.says(Pubcomp{robot.hears<Pubrel>().msg_id});
    robot.hears<Pingresp>();
    EXPECT_EQ(state(), SessionState::asleep);
}

/// Adopted in the midst of its awakening: it was sent a message, and has not answered.
class AdoptionOfAnAwakened : public Adoption {
protected:
    void SetUp() override {
        publisher.connects();
        robot.connects(true, 10);
        robot.subscribes("cmd");
        robot.says(Disconnect{true, 100});
        robot.hears<Disconnect>();
        const auto cmd = publisher.registers("cmd");
        publisher.publishes(cmd, "one", Qos::at_least_once);
        robot.says(Pingreq{"robot"});
        robot.hears<Publish>();
        takes_over(robot);
        answers("one");
    }
    void answers(std::string_view payload) {
        const auto publish = robot.hears<Publish>();
        EXPECT_EQ(as_text(publish.data), payload);
        robot.says(Puback{publish.topic, publish.msg_id, ReturnCode::accepted});
    }
    SessionState state() { return heir.core.image("robot")->header.state; }
};

// It connected at its former home, which was cut off (simulator, seed 205595).
TEST_F(AdoptionOfAnAwakened, WhoMayHaveConnectedIsNotLeftAsleep) {  // P2
    robot.hears<Pingresp>();
    EXPECT_EQ(state(), SessionState::active);
    publisher.moves_to(heir);
    publisher.connects();
    publisher.publishes(publisher.registers("cmd"), "two", Qos::at_least_once);
    answers("two");
    robot.hears_nothing();
    heir.expects_mirror_to_agree();
}

// It asks again only when nothing comes for Tretry (6.14d).
TEST_F(AdoptionOfAnAwakened, WhoIsAwakeGetsItsPingrespWhenNothingWaits) {  // 6.14b
    robot.hears<Pingresp>();
    robot.hears_nothing();
}

TEST_F(AdoptionOfAnAwakened, WhoIsAwakeMayAskAgainAndSleepsOn) {  // 6.14b
    robot.ignores_what_came();
    robot.says(Pingreq{"robot"});
    robot.hears<Pingresp>();
    EXPECT_EQ(state(), SessionState::asleep);
    heir.expects_mirror_to_agree();
}

TEST_F(Adoption, ReleasePublishesNoWillAndForgets) {  // P7
    robot.says(robot.connect(false, 10, true));
    robot.hears<Willtopicreq>();
    robot.says(Willtopic{Qos::at_least_once, false, "gone"});
    robot.hears<Willmsgreq>();
    robot.says(Willmsg{as_octets("robot")});
    robot.hears<Connack>();
    publisher.connects();
    publisher.subscribes("gone");
    const auto image = home.core.release("robot", home.actions);
    home.drain();
    ASSERT_TRUE(image);
    EXPECT_EQ(image->will->topic, "gone");
    home.waits(1min);
    publisher.hears_nothing();
    EXPECT_EQ(home.core.session_count(), 1u);
    EXPECT_FALSE(home.core.release("robot", home.actions));
    home.expects_mirror_to_agree();
}

/// Two brokers that hand sessions to and fro while clients of both publish: every message reaches
/// every subscriber once (QoS 2), whatever broker was ahead.
class HandOff : public ::testing::TestWithParam<std::uint64_t> {};

TEST_P(HandOff, LosesAndDoublesNothing) {
    SCOPED_TRACE("seed " + std::to_string(GetParam()));
    Random random{GetParam()};
    ScriptedBroker brokers[2] = {ScriptedBroker{options_of("x")}, ScriptedBroker{options_of("y")}};
    ScriptedClient publishers[2] = {{brokers[0], "p0"}, {brokers[1], "p1"}};
    TopicId topic[2];
    for (int i = 0; i < 2; ++i) {
        publishers[i].connects(false);
        topic[i] = publishers[i].registers("t");
    }
    ScriptedClient subscriber{brokers[0], "s"};
    subscriber.connects(false);
    subscriber.subscribes("t");
    int at = 0;
    std::map<std::string, int> heard;
    int published = 0;
    Seq applied[2] = {0, 0};  // of the other's log
    const auto apply = [&](int at_broker, std::uint32_t most) {
        ScriptedBroker& other = brokers[1 - at_broker];
        for (; most > 0 && applied[at_broker] < other.log.size(); --most) {
            const LogEvent& event = other.log[applied[at_broker]++];
            if (const auto* p = std::get_if<Published>(&event)) {
                brokers[at_broker].core.on_peer_message(brokers[at_broker].now, p->message,
                                                        brokers[at_broker].actions);
                brokers[at_broker].drain();
            }
        }
        brokers[at_broker].core.advance_cursor({other.core_log(), applied[at_broker]});
    };
    const auto hear = [&] {
        while (const MqttsnMessage* message = subscriber.next()) {
            if (const auto* publish = std::get_if<Publish>(message)) {
                if (!publish->dup) ++heard[std::string{as_text(publish->data)}];
                subscriber.says(Pubrec{publish->msg_id});
            } else if (const auto* release = std::get_if<Pubrel>(message)) {
                subscriber.says(Pubcomp{release->msg_id});
            }
        }
    };
    for (int step = 0; step < 400; ++step) {
        const int who = static_cast<int>(random.below(2));
        switch (random.below(4)) {
            case 0:
            case 1:
                publishers[who].publishes(topic[who], std::to_string(published++),
                                          Qos::exactly_once);
                break;
            case 2:
                apply(who, random.below(6));
                break;
            default: {
                hear();
                auto image = brokers[at].core.release("s", brokers[at].actions);
                brokers[at].drain();
                ASSERT_TRUE(image);
                at = 1 - at;
                // What the new home worked through and the old one had not.
                std::vector<MessagePtr> missed;
                for (int log = 0; log < 2; ++log) {
                    const LogId id = brokers[log].core_log();
                    const Seq ours =
                        log == at ? brokers[at].core.last_seq() : brokers[at].core.cursor(id);
                    Seq theirs = 0;
                    for (const auto& p : image->worked_through) {
                        if (p.log == id) theirs = p.seq;
                    }
                    for (Seq seq = theirs + 1; seq <= ours; ++seq) {
                        if (const auto* p = std::get_if<Published>(&brokers[log].log[seq - 1])) {
                            missed.push_back(p->message);
                        }
                    }
                }
                ASSERT_TRUE(
                    brokers[at].core.adopt(brokers[at].now, *image, missed, brokers[at].actions));
                brokers[at].drain();
                subscriber.moves_to(brokers[at]);
                break;
            }
        }
        hear();
    }
    apply(0, 1'000'000);
    apply(1, 1'000'000);
    hear();
    EXPECT_EQ(heard.size(), static_cast<std::size_t>(published));
    for (const auto& [data, times] : heard) EXPECT_EQ(times, 1) << data;
    for (ScriptedBroker& broker : brokers) broker.expects_mirror_to_agree();
}

INSTANTIATE_TEST_SUITE_P(Seeds, HandOff, ::testing::Range<std::uint64_t>(1, 21));

}  // namespace
}  // namespace romano::broker::adoption_test
