// Two brokers had one session, as after a heal: which copy stays, and what it takes from the other.

#include <gmock/gmock.h>

#include <algorithm>
#include <cstdint>

#include "tests/broker/core/adopting_brokers.h"

namespace romano::broker::two_homes_test {
namespace {

using TwoHomes = AdoptingBrokers;

TEST_F(TwoHomes, TwoHomesOfAPartedClusterDoNotUseTheSameMsgIds) {  // P2
    publisher.connects();
    robot.connects(false);
    robot.subscribes("cmd");
    const auto topic = publisher.registers("cmd");
    publisher.publishes(topic, "go", Qos::exactly_once);
    const auto in_flight = static_cast<std::uint16_t>(robot.hears<Publish>().msg_id);
    publisher.publishes(topic, "stop", Qos::exactly_once);
    takes_over(robot);
    robot.says(Pubrec{robot.hears<Publish>().msg_id});
    robot.says(Pubcomp{robot.hears<Pubrel>().msg_id});
    // The old home, cut off, may go on with the ids that follow. This one does not.
    const auto next = static_cast<std::uint16_t>(robot.hears<Publish>().msg_id);
    EXPECT_GT(static_cast<std::uint16_t>(next - in_flight), 0x1000);
    EXPECT_LT(static_cast<std::uint16_t>(next - in_flight), 0xF000);
}

TEST_F(TwoHomes, TheCopyWhoseClientWasHeardWins) {
    robot.connects(false);
    const SessionImage stale = image_of(home, "robot");
    takes_over(robot);
    robot.says(Pingreq{});
    robot.hears<Pingresp>();
    EXPECT_FALSE(heir.core.adopt(heir.now, stale, {}, heir.actions));
    EXPECT_TRUE(home.core.adopt(home.now, *heir.core.image("robot"), {}, home.actions));
    home.drain();
    EXPECT_EQ(home.core.image("robot")->header.epoch, 2u);
    home.expects_mirror_to_agree();
}

// Other homes have compared theirs with it, and must not both give way.
TEST_F(TwoHomes, TheRankOfACopyDoesNotFallWhenAnotherTakesItsPlace) {
    robot.connects(false);
    const SessionHeader before = *home.core.header("robot");
    SessionImage later = image_of(home, "robot");
    later.header.last_heard.value += 1;
    EXPECT_TRUE(home.core.adopt(home.now, later, {}, home.actions));
    const SessionHeader& now = *home.core.header("robot");
    EXPECT_TRUE(now.provisional);
    EXPECT_TRUE(outranks(now, before));
    later.header.epoch = now.epoch + 1;
    later.header.last_heard = {};
    EXPECT_TRUE(home.core.adopt(home.now, later, {}, home.actions));
    EXPECT_GT(home.core.header("robot")->last_heard, before.last_heard);
}

// Beyond a cut: it knows nothing of the session that the heir has.
TEST_F(TwoHomes, ASessionThatIsBegunAnewOutranksOneThatItsBrokerNeverSaw) {
    robot.connects();
    SessionImage older = image_of(home, "robot");
    older.header.epoch += 3;  // heard at so many homes since
    ScriptedBroker stranger{options_of("stranger")};
    stranger.now = home.now + std::chrono::seconds{1};
    ScriptedClient anew{stranger, "robot"};
    anew.connects();
    EXPECT_FALSE(stranger.core.adopt(stranger.now, older, {}, stranger.actions));
    EXPECT_TRUE(outranks(stranger.core.image("robot")->header, older.header));
}

// It was asleep as the heir knows, and the heir hears a word of then late (simulator, seed
// 1107968).
TEST_F(TwoHomes, TheCopyThatTheClientConnectedToOutranksOneThatHeardItLater) {
    robot.connects(false);
    robot.says(Pingreq{});
    robot.hears<Pingresp>();
    const SessionImage former = image_of(home, "robot");
    robot.connects(false);
    const SessionHeader connected = image_of(home, "robot").header;
    ASSERT_TRUE(heir.core.adopt(heir.now, former, {}, heir.actions));
    heir.drain();
    heir.waits(1s);
    robot.moves_to(heir);
    robot.says(Pingreq{});
    robot.hears<Pingresp>();
    const SessionHeader late = heir.core.image("robot")->header;
    ASSERT_FALSE(late.provisional);
    ASSERT_GT(late.last_heard, connected.last_heard);
    EXPECT_TRUE(outranks(connected, late));
}

// Of two copies the one to which it published later knows what it has begun (simulator, seed
// 1403805).
TEST_F(TwoHomes, AMirrorKnowsThatAPublisherWasHeard) {
    publisher.connects();
    const auto topic = publisher.registers("cmd");
    const HybridTime before = image_of(home, "publisher").header.last_heard;
    home.waits(1s);
    publisher.says(Publish{false, Qos::exactly_once, false, mqttsn::TopicIdType::normal, topic,
                           MsgId{9}, as_octets("go")});
    const SessionImage image = image_of(home, "publisher");
    EXPECT_GT(image.header.last_heard, before);
    EXPECT_EQ(image.header.last_heard, home.core.header("publisher")->last_heard)
        << "of no later word than its home: by their ranks two homes would both give way";
    EXPECT_THAT(image.unreleased, testing::ElementsAre(MsgId{9}));
    EXPECT_EQ(image.header.last_published, image.header.last_heard);
}

/// A client that publishes under one id has two homes: the first one, which stays, and its heir.
class TwoHomesOfAPublisher : public AdoptingBrokers {
protected:
    TwoHomesOfAPublisher() {
        publisher.connects();
        topic = publisher.registers("cmd");
    }
    void begins(std::string_view data, bool again = false) {
        publisher.says(Publish{again, Qos::exactly_once, false, mqttsn::TopicIdType::normal, topic,
                               MsgId{9}, as_octets(data)});
        publisher.hears<Pubrec>();
    }
    void ends() {
        publisher.says(Pubrel{MsgId{9}});
        publisher.hears<Pubcomp>();
    }
    void is_heard_at(ScriptedBroker& at) {
        at.waits(1s);
        publisher.moves_to(at);
        publisher.says(Pingreq{});
        publisher.hears<Pingresp>();
    }
    void goes_on_at_its_heir(SessionImage image) {
        heir.waits(1s);
        ASSERT_TRUE(heir.core.adopt(heir.now, std::move(image), {}, heir.actions));
        heir.drain();
        is_heard_at(heir);
    }
    /// As SessionMoved says: from the mirror, with the header that its home has.
    void comes_back() {
        SessionImage image = image_of(heir, publisher.id);
        image.header = *heir.core.header(publisher.id);
        ASSERT_TRUE(home.core.adopt(home.now, std::move(image), {}, home.actions));
        home.drain();
        publisher.moves_to(home);
    }
    [[nodiscard]] std::ptrdiff_t published_at_home() const {
        return std::ranges::count_if(home.log, [](const LogEvent& event) {
            return std::holds_alternative<Published>(event);
        });
    }

    TopicId topic{};
};

// Its home stood still, and heard the PUBLISH before it heard that it had been replaced (simulator,
// seeds 6120 and 12079 as shipped).
TEST_F(TwoHomesOfAPublisher, P3_WhatItBeganAtTheOneIsKnownThoughItWasHeardLaterAtTheOther) {
    SessionImage former = image_of(home, publisher.id);
    begins("go");
    goes_on_at_its_heir(std::move(former));
    comes_back();
    begins("go", true);
    EXPECT_EQ(published_at_home(), 1);
}

// By a word that came late.
TEST_F(TwoHomesOfAPublisher, P2_WhatItEndedAtTheOneIsOverThoughItWasHeardLaterAtTheOther) {
    begins("go");
    goes_on_at_its_heir(image_of(home, publisher.id));
    ends();
    home.waits(2s);
    is_heard_at(home);
    comes_back();
    begins("stop");
    EXPECT_EQ(published_at_home(), 2);
}

TEST_F(TwoHomesOfAPublisher, P2_WhatItBeganAtTheOneAndEndedAtTheOtherIsOver) {
    SessionImage former = image_of(home, publisher.id);
    begins("go");
    goes_on_at_its_heir(std::move(former));
    ends();
    const HybridTime ended = heir.core.header(publisher.id)->last_published;
    comes_back();
    EXPECT_EQ(home.core.header(publisher.id)->last_published, ended);
    begins("stop");
    EXPECT_EQ(published_at_home(), 2);
}

TEST_F(TwoHomesOfAPublisher, P2_WhatItBeganAtTheOneIsOverWhenItConnectsAnewAtTheOther) {
    SessionImage former = image_of(home, publisher.id);
    begins("go");
    goes_on_at_its_heir(std::move(former));
    publisher.connects();
    topic = publisher.registers("cmd");
    comes_back();
    begins("stop");
    EXPECT_EQ(published_at_home(), 2);
}

/// A kept session in two halves: the robot's home is out of sight, and its next broker, to whom it
/// is a stranger, gives the same topic id to another topic (simulator, seed 82022).
class TwoHalves : public AdoptingBrokers {
protected:
    TwoHalves() {
        publisher.connects();
        robot.connects(false);
        robot.subscribes("older");
        older = image_of(home, "robot");
        older.header.epoch = 5;
        heir.waits(1s);
        robot.moves_to(heir);
        robot.connects(false);
        robot.subscribes("newer");
        newer = image_of(heir, "robot");
    }
    /// The robot is subscribed to both, and hears what it subscribed to last under the id of then.
    void hears_what_it_was_told_last(ScriptedBroker& at) {
        robot.moves_to(at);
        EXPECT_EQ(image_of(at, "robot").subscriptions.size(), 2U);
        publisher.moves_to(at);
        publisher.connects();
        publisher.publishes(publisher.registers("newer"), "go");
        EXPECT_EQ(robot.hears<Publish>().topic, newer.topics.front().id);
        publisher.publishes(publisher.registers("older"), "go");
        EXPECT_NE(robot.hears<Register>().topic_id, newer.topics.front().id);
    }

    SessionImage older, newer;
    ScriptedBroker third{options_of("third")};
};

TEST_F(TwoHalves, TheHalfThatWinsKeepsWhatTheClientWasToldLater) {
    EXPECT_TRUE(heir.core.adopt(heir.now, older, {}, heir.actions));
    heir.drain();
    hears_what_it_was_told_last(heir);
}

TEST_F(TwoHalves, TheHalfThatStaysLearnsWhatTheClientWasToldLater) {
    third.waits(1s);
    EXPECT_TRUE(third.core.adopt(third.now, older, {}, third.actions));
    EXPECT_FALSE(third.core.adopt(third.now, newer, {}, third.actions));
    third.drain();
    EXPECT_EQ(image_of(third, "robot").header.epoch, 5U);
    hears_what_it_was_told_last(third);
}

TEST_F(TwoHalves, WhatWasToldBeforeIsOver) {
    newer.header.epoch = 6;
    EXPECT_TRUE(third.core.adopt(third.now, newer, {}, third.actions));
    EXPECT_FALSE(third.core.adopt(third.now, older, {}, third.actions));
    third.drain();
    EXPECT_EQ(image_of(third, "robot").topics, newer.topics);
    EXPECT_EQ(image_of(third, "robot").subscriptions, newer.subscriptions);
}

// The older half sleeps; whoever takes the client for asleep sends it nothing (simulator, seed
// 14253 as shipped).
TEST_F(TwoHalves, P2_TheHalfThatWinsKnowsThatTheClientIsConnected) {
    older.header.state = SessionState::asleep;
    older.header.sleep_s = 100;
    EXPECT_TRUE(heir.core.adopt(heir.now, older, {}, heir.actions));
    heir.drain();
    hears_what_it_was_told_last(heir);
}

TEST_F(TwoHalves, TheHalfThatWinsLetsAClientSleepThatFellAsleepLater) {
    older.header.state = SessionState::asleep;
    older.header.sleep_s = 100;
    older.header.last_heard = heir.core.header("robot")->last_heard;
    EXPECT_TRUE(heir.core.adopt(heir.now, older, {}, heir.actions));
    EXPECT_EQ(image_of(heir, "robot").header.state, SessionState::asleep);
}

// A QoS 2 receiver takes a message for the one that it has not released under the same msg id
// (simulator, seed 145609).
TEST_F(TwoHomes, MsgIdsGoOnFarFromWhereBothHomesWere) {
    constexpr std::uint16_t far = 0x1000;
    const auto distance = [](MsgId a, MsgId b) {
        const auto ahead =
            static_cast<std::uint16_t>(static_cast<unsigned>(a) - static_cast<unsigned>(b));
        return std::min<int>(ahead, 0x10000 - ahead);
    };
    publisher.connects();
    robot.connects();
    robot.subscribes("cmd");
    publisher.publishes(publisher.registers("cmd"), "go", Qos::at_least_once);
    const MsgId idle = robot.hears<Publish>().msg_id;
    robot.says(Puback{mqttsn::TopicId{1}, idle, ReturnCode::accepted});
    SessionImage image = image_of(home, "robot");
    ASSERT_THAT(image.deliveries, testing::IsEmpty());
    for (const unsigned elsewhere : {0x2000U, 0x5000U, 0x8000U, 0xB000U, 0xE000U}) {
        for (std::uint64_t seed = 1; seed <= 200; ++seed) {
            BrokerOptions options = options_of("heir");
            BrokerCore core{options, seed};
            Actions actions;
            image.header.epoch = 1;
            image.last_msg_id = MsgId{static_cast<std::uint16_t>(elsewhere)};
            ASSERT_TRUE(core.adopt(Instant{1s}, image, {}, actions));
            const MsgId there = core.image("robot")->last_msg_id;
            image.header.epoch = 2;
            image.last_msg_id = idle;
            ASSERT_TRUE(core.adopt(Instant{1s}, image, {}, actions));
            const MsgId here = core.image("robot")->last_msg_id;
            ASSERT_GE(distance(here, idle), far);
            ASSERT_GE(distance(here, there), far);
        }
    }
}

/// The robot holds a message that the heir's copy has not released, and is at its home again. If
/// that id came again, the robot would take the message for this one (simulator, seeds 404563 and
/// 407790).
class AnOpenExchange : public AdoptingBrokers {
protected:
    AnOpenExchange() {
        robot.connects(false);
        robot.subscribes("cmd");
        takes_over(robot);
        publisher.moves_to(heir);
        publisher.connects();
        publisher.publishes(publisher.registers("cmd"), "go", Qos::exactly_once);
        open = robot.hears<Publish>().msg_id;
        gives_way = image_of(heir, "robot");
        robot.moves_to(home);
        publisher.moves_to(home);
        publisher.connects();
        topic = publisher.registers("cmd");
    }
    void expects_it_released_until_it_answers() {
        EXPECT_EQ(robot.hears<Pubrel>().msg_id, open);  // lost
        publisher.publishes(topic, "stop", Qos::exactly_once);
        EXPECT_EQ(robot.hears<Pubrel>().msg_id, open);
        robot.says(Pubcomp{open});
        const MsgId next = robot.hears<Publish>().msg_id;
        EXPECT_NE(next, open);
        robot.says(Pubrec{next});
        EXPECT_EQ(robot.hears<Pubrel>().msg_id, next);
        robot.says(Pubcomp{next});
        publisher.publishes(topic, "turn", Qos::exactly_once);
        robot.hears<Publish>();
        EXPECT_EQ(home.dropped(Drop::unexpected), 0U);
    }

    MsgId open{};
    SessionImage gives_way;
    mqttsn::TopicId topic{};
};

TEST_F(AnOpenExchange, P2_IsFinishedByTheCopyThatStays) {
    EXPECT_FALSE(home.core.adopt(home.now, gives_way, {}, home.actions));
    home.drain();
    expects_it_released_until_it_answers();
}

TEST_F(AnOpenExchange, P2_IsFinishedByTheCopyThatComes) {
    SessionImage comes = image_of(home, "robot");
    ++comes.header.epoch;
    home.core.release("robot", home.actions);
    EXPECT_TRUE(home.core.adopt(home.now, gives_way, {}, home.actions));
    home.drain();
    EXPECT_EQ(robot.hears<Publish>().msg_id, open);
    EXPECT_TRUE(home.core.adopt(home.now, comes, {}, home.actions));
    home.drain();
    expects_it_released_until_it_answers();
}

/// Both copies have a message of a third broker, and one has begun to send it (simulator, seed
/// 935207).
class AnExchangeOfOneCopy : public AdoptingBrokers {
protected:
    AnExchangeOfOneCopy() {
        robot.connects(false);
        robot.subscribes("cmd");
        waiting = image_of(home, "robot");
        const LogPosition position{{broker_id_of("third"), 1}, 1};
        const MessagePtr message = published_at(position, "go");
        const SessionImage own = waiting;
        home.core.release("robot", home.actions);
        EXPECT_TRUE(home.core.adopt(home.now, own, {message}, home.actions));
        home.drain();
        begun = robot.hears<Publish>().msg_id;
        waiting.deliveries = {{.position = position, .message = message, .qos = Qos::exactly_once}};
    }
    void meets_the_other_copy(std::uint64_t epochs_ahead, bool comes) {
        waiting.header.epoch = image_of(home, "robot").header.epoch + epochs_ahead;
        EXPECT_EQ(home.core.adopt(home.now, waiting, {}, home.actions), comes);
        home.drain();
    }

    MsgId begun{};
    SessionImage waiting;
};

TEST_F(AnExchangeOfOneCopy, P3_GoesOnUnderItsIdInTheCopyThatComes) {
    meets_the_other_copy(1, true);
    EXPECT_EQ(robot.hears<Publish>().msg_id, begun);
}

TEST_F(AnExchangeOfOneCopy, P3_WhatTheClientHasReceivedIsOnlyReleasedByTheCopyThatComes) {
    robot.says(Pubrec{begun});
    robot.hears<Pubrel>();
    meets_the_other_copy(1, true);
    EXPECT_EQ(robot.hears<Pubrel>().msg_id, begun);
    robot.says(Pubcomp{begun});
    robot.hears_nothing();
}

TEST_F(AnExchangeOfOneCopy, P3_OfTheCopyThatGivesWayGoesOnInTheOneThatStays) {
    const SessionImage gives_way = image_of(home, "robot");
    waiting.header.state = SessionState::asleep;
    waiting.header.sleep_s = 100;
    ++waiting.header.epoch;
    EXPECT_TRUE(heir.core.adopt(heir.now, waiting, {}, heir.actions));
    heir.drain();
    robot.moves_to(heir);
    EXPECT_FALSE(heir.core.adopt(heir.now, gives_way, {}, heir.actions));
    heir.drain();
    robot.hears_nothing();
    robot.says(Pingreq{"robot"});
    EXPECT_EQ(robot.hears<Publish>().msg_id, begun);
}

}  // namespace
}  // namespace romano::broker::two_homes_test
