// P7: a will is published exactly once when a client is lost, and never because its home is.

#include <gmock/gmock.h>

#include "tests/overlay/member/steps.h"

namespace romano::test {
namespace {

using namespace std::chrono_literals;
using mqttsn::Qos;
using testing::ElementsAre;
using testing::IsEmpty;

/// A robot of broker 1 that has spoken its last word, which broker 1 did not outlive either; and
/// one that waits for the will at broker 3.
struct LastWord {
    LastWord() {
        start(brokers, {1, 2, 3});
        robot.connect_with_will("gone", 1);
        brokers.run_for(100ms);
        brokers.kill(1);
    }
    /// How long it takes until then, a millisecond exactly.
    template <typename Condition>
    Duration until(const Condition& condition) {
        Duration waited{0};
        for (; !condition() && waited < 5s; waited += 1ms) brokers.run_for(1ms);
        return waited;
    }

    Brokers brokers;
    Robot& watcher = brokers.robot("watcher", 3);
    Robot& robot = brokers.robot("robot", 1);
};

TEST(Will, P7_IsPublishedOnceByTheHeirOfACrashedHome) {
    LastWord scene;
    scene.watcher.connect();
    scene.watcher.subscribe("gone", Qos::exactly_once);
    scene.brokers.run_for(1s);
    EXPECT_THAT(scene.watcher.received(), IsEmpty()) << "it may live";
    scene.brokers.run_for(4s);
    EXPECT_THAT(scene.watcher.received(), ElementsAre("robot"));
}

// The heir's time for the client is up while its session goes back to its own broker.
TEST(Will, P7_IsPublishedOnceWhenTheTimeIsUpAmidAHandBack) {
    const auto watched = [](LastWord& scene) -> Robot& {
        scene.watcher.connect();
        scene.watcher.subscribe("gone", Qos::exactly_once);
        return scene.watcher;
    };
    LastWord lost;
    Robot& watcher = watched(lost);
    const Duration lost_after = lost.until([&] { return !watcher.received().empty(); });
    LastWord back;
    back.brokers.start(1);
    const Duration back_after = back.until([&] { return !back.brokers.sessions_at(1).empty(); });
    ASSERT_LT(back_after, lost_after);
    for (Duration early = -2ms; early <= 10ms; early += 1ms) {
        LastWord scene;
        watched(scene);
        scene.brokers.run_for(lost_after - back_after - early);
        scene.brokers.start(1);
        scene.brokers.run_for(4s);
        EXPECT_THAT(scene.watcher.received(), ElementsAre("robot")) << early / 1ms << " ms early";
    }
}

// All brokers stand still, and what their client says meanwhile waits to be read.
TEST(Will, P7_IsNotPublishedForAStandstillOfAllBrokers) {
    Brokers brokers;
    start(brokers, {1, 2, 3});
    Robot& watcher = subscriber(brokers, "watcher", 3, Qos::exactly_once, "gone");
    Robot& robot = brokers.robot("robot", 1);
    robot.connect_with_will("gone", 1);
    robot.publish("pose", "0", Qos::exactly_once);
    brokers.run_for(500ms);
    for (const int rank : {1, 2, 3}) brokers.stall(rank);
    for (int i = 0; i < 6; ++i) {
        robot.publish("pose", "1", Qos::at_most_once);
        brokers.run_for(500ms);
    }
    for (const int rank : {1, 2, 3}) brokers.wake(rank);
    for (int i = 0; i < 6; ++i) {
        robot.publish("pose", "2", Qos::at_most_once);
        brokers.run_for(500ms);
    }
    EXPECT_THAT(watcher.received(), IsEmpty());
    EXPECT_EQ(robot.rejections(), 0);
}

// One of three is cut off for longer than all keep-alives: it goes on for everybody, and hears
// nobody but its own robots.
TEST(Will, P7_OfClientsThatLiveElsewhereIsNotPublishedByABrokerThatWasCutOff) {
    Brokers brokers;
    start(brokers, {1, 2, 3});
    Robot& watcher = subscriber(brokers, "watcher", 3, Qos::exactly_once, "gone");
    Robot& elsewhere = brokers.robot("elsewhere", 2);
    elsewhere.connect_with_will("gone", 1);
    elsewhere.publish("pose", "0", Qos::exactly_once);
    Robot& here = brokers.robot("here", 1);
    here.connect_with_will("gone", 1);
    here.publish("pose", "0", Qos::exactly_once);
    Robot& taken_over = brokers.robot("taken over", 1, 2);  // the others reach it
    taken_over.connect_with_will("gone", 1);
    taken_over.publish("pose", "0", Qos::exactly_once);
    brokers.run_for(200ms);
    for (const int other : {2, 3}) brokers.cut(1, other);
    for (int i = 0; i < 10; ++i) {
        for (Robot* robot : {&elsewhere, &taken_over})
            robot->publish("pose", "1", Qos::at_most_once);
        if (i < 4) here.publish("pose", "1", Qos::at_most_once);  // then it dies
        brokers.run_for(400ms);
    }
    EXPECT_THAT(watcher.received(), ElementsAre("here")) << "to this side it is lost at once";
    brokers.heal();
    for (int i = 0; i < 10; ++i) {
        for (Robot* robot : {&elsewhere, &taken_over})
            robot->publish("pose", "1", Qos::at_most_once);
        brokers.run_for(400ms);
    }
    EXPECT_THAT(watcher.received(), ElementsAre("here", "here")) << "and once on its own side";
    EXPECT_EQ(elsewhere.rejections() + taken_over.rejections(), 0);
}

}  // namespace
}  // namespace romano::test
