// P7: a will is published exactly once when a client is lost, and never because its home is.

#include <gmock/gmock.h>

#include "tests/overlay/member/steps.h"

namespace romano::test::will_test {
namespace {

using namespace std::chrono_literals;
using mqttsn::Qos;
using testing::ElementsAre;
using testing::IsEmpty;

/// It has a will for the topic "gone", and a topic id for "pose".
Robot& mortal(Brokers& brokers, const std::string& name, int broker, int site) {
    Robot& robot = brokers.robot(name, broker, site);
    robot.connect_with_will("gone", 1);
    robot.publish("pose", "0", Qos::exactly_once);
    return robot;
}

/// More often than a keep-alive ends.
void go_on_speaking(Brokers& brokers, std::initializer_list<Robot*> robots, Duration time) {
    constexpr Duration often = 400ms;
    for (Duration passed{0}; passed < time; passed += often) {
        for (Robot* robot : robots) robot->publish("pose", "1", Qos::at_most_once);
        brokers.run_for(often);
    }
}

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
    Robot& robot = mortal(brokers, "robot", 1, 1);
    brokers.run_for(500ms);
    for (const int rank : {1, 2, 3}) brokers.stall(rank);
    go_on_speaking(brokers, {&robot}, 3s);
    for (const int rank : {1, 2, 3}) brokers.wake(rank);
    go_on_speaking(brokers, {&robot}, 3s);
    EXPECT_THAT(watcher.received(), IsEmpty());
    EXPECT_EQ(robot.rejections(), 0);
}

// One of three is cut off for longer than all keep-alives: it goes on for everybody, and hears
// nobody but its own robots.
TEST(Will, P7_OfClientsThatLiveElsewhereIsNotPublishedByABrokerThatWasCutOff) {
    Brokers brokers;
    start(brokers, {1, 2, 3});
    Robot& watcher = subscriber(brokers, "watcher", 3, Qos::exactly_once, "gone");
    Robot& elsewhere = mortal(brokers, "elsewhere", 2, 2);
    Robot& here = mortal(brokers, "here", 1, 1);
    Robot& taken_over = mortal(brokers, "taken over", 1, 2);  // the others reach it
    brokers.run_for(200ms);
    for (const int other : {2, 3}) brokers.cut(1, other);
    go_on_speaking(brokers, {&elsewhere, &taken_over, &here}, 1600ms);
    go_on_speaking(brokers, {&elsewhere, &taken_over}, 2400ms);  // the other one is dead
    EXPECT_THAT(watcher.received(), ElementsAre("here")) << "to this side it is lost at once";
    brokers.heal();
    go_on_speaking(brokers, {&elsewhere, &taken_over}, 4s);
    EXPECT_THAT(watcher.received(), ElementsAre("here", "here")) << "and once on its own side";
    EXPECT_EQ(elsewhere.rejections() + taken_over.rejections(), 0);
}

}  // namespace
}  // namespace romano::test::will_test
