// Section 6.4 and the wills of 6.2, 6.3, 6.12, 6.14: what is published when a client is lost.

#include "tests/conformance/suite.h"

namespace romano::conformance::will_test {
namespace {

class WithWatcher : public PatientSuite {
protected:
    /// Somebody who hears the will.
    Client& watcher(int qos = 0) {
        Client& one = connected();
        will_id_ = one.subscribes(topic("will"), qos);
        return one;
    }
    [[nodiscard]] unsigned will_id() const { return will_id_; }

    /// Says its last word: from now on it is silent, and lost after a second and a half. (Before,
    /// it is not supervised, so that a slow machine does not lose it in the middle of a case.)
    static void falls_silent(Client& client) { client.connects(no_flags, 1); }

private:
    unsigned will_id_ = 0;
};

CONFORMANCE_SUITE(S6_4_Will, WithWatcher);

TEST_P(S6_4_Will, IsPublishedWhenTheClientIsLost) {
    Client& heir = watcher();
    Client& robot = client();
    robot.connects_with_will(topic("will"), "gone", no_flags, clean, 1);
    heir.hears_publish(no_flags, will_id(), "gone");
    hears_nothing(heir);
}

TEST_P(S6_4_Will, IsPublishedAtItsQos) {
    Client& heir = watcher(2);
    Client& first = client();
    first.connects_with_will(topic("will"), "1", qos1, clean, 1);
    heir.takes(qos1, will_id(), "1");
    Client& second = client();
    second.connects_with_will(topic("will"), "2", qos2, clean, 1);
    heir.takes(qos2, will_id(), "2");
}

TEST_P(S6_4_Will, IsRetainedWhenItSaysSo) {
    Client& heir = watcher();
    Client& robot = client();
    robot.connects_with_will(topic("will"), "gone", retain, clean, 1);
    forget_retained(topic("will"));
    heir.hears_publish(no_flags, will_id(), "gone");
    Client& late = connected();
    const unsigned id = late.subscribes(topic("will"));
    late.hears_publish(retain, id, "gone");
}

TEST_P(S6_4_Will, s6_12_IsNotPublishedOnDisconnect) {
    Client& heir = watcher();
    Client& robot = client();
    robot.connects_with_will(topic("will"), "gone", no_flags, clean, 1);
    robot.disconnects();
    Client& other = client();  // lost meanwhile: the same time has passed for both
    other.connects_with_will(topic("will"), "other", no_flags, clean, 1);
    heir.hears_publish(no_flags, will_id(), "other");
    hears_nothing(heir);
}

TEST_P(S6_4_Will, s6_14_IsPublishedWhenASleeperDoesNotComeBack) {
    Client& heir = watcher();
    Client& robot = client();
    robot.connects_with_will(topic("will"), "gone");
    robot.sleeps(1);
    heir.hears_publish(no_flags, will_id(), "gone");
}

TEST_P(S6_4_Will, s6_3_IsErasedByACleanConnectWithoutWill) {
    Client& heir = watcher();
    Client& robot = client();
    robot.connects_with_will(topic("will"), "gone", no_flags, no_flags);
    robot.connects(clean, 1);
    Client& other = client();
    other.connects_with_will(topic("will"), "other", no_flags, clean, 1);
    heir.hears_publish(no_flags, will_id(), "other");
    hears_nothing(heir);
}

TEST_P(S6_4_Will, s6_3_IsKeptByAConnectWithoutCleanSessionAndWill) {
    Client& heir = watcher();
    Client& robot = client();
    robot.connects_with_will(topic("will"), "gone", no_flags, no_flags, 0);
    robot.disconnects();
    robot.connects(no_flags, 1);
    heir.hears_publish(no_flags, will_id(), "gone");
}

TEST_P(S6_4_Will, s6_3_IsReplacedByAConnectWithAnotherOne) {
    Client& heir = watcher();
    Client& robot = client();
    robot.connects_with_will(topic("will"), "old", no_flags, no_flags, 0);
    robot.connects_with_will(topic("will"), "new", no_flags, no_flags, 1);
    heir.hears_publish(no_flags, will_id(), "new");
}

TEST_P(S6_4_Will, s6_3a_AnEmptyWilltopicDeletesIt) {
    Client& heir = watcher();
    Client& robot = client();
    robot.connects_with_will(topic("will"), "gone", no_flags, no_flags);
    robot.says(connect(robot.id, with_will, 1));
    robot.hears(willtopicreq());
    robot.says(empty_willtopic());
    robot.hears(connack(accepted));
    Client& other = client();
    other.connects_with_will(topic("will"), "other", no_flags, clean, 1);
    heir.hears_publish(no_flags, will_id(), "other");
    hears_nothing(heir);
}

TEST_P(S6_4_Will, s6_3a_AWilltopicOfFlagsAloneMeansTheSame) {
    Client& robot = client();
    robot.says(connect(robot.id, clean | with_will));
    robot.hears(willtopicreq());
    robot.says(willtopic(""));
    robot.hears(connack(accepted));
}

TEST_P(S6_4_Will, a_WilltopicupdReplacesTheTopicAndItsFlags) {
    Client& heir = watcher(1);
    Client& robot = client();
    robot.connects_with_will(topic("elsewhere"), "gone", no_flags, no_flags);
    robot.says(willtopicupd(topic("will"), qos1));
    robot.hears({0x03, 0x1B, 0x00});
    falls_silent(robot);
    heir.takes(qos1, will_id(), "gone");
}

TEST_P(S6_4_Will, a_WillmsgupdReplacesTheMessage) {
    Client& heir = watcher();
    Client& robot = client();
    robot.connects_with_will(topic("will"), "old", no_flags, no_flags);
    robot.says(willmsgupd("new"));
    robot.hears({0x03, 0x1D, 0x00});
    falls_silent(robot);
    heir.hears_publish(no_flags, will_id(), "new");
}

TEST_P(S6_4_Will, a_UpdatesGiveAWillToAClientThatHadNone) {
    Client& heir = watcher();
    Client& robot = connected(no_flags);
    robot.says(willtopicupd(topic("will")));
    robot.hears(willtopicresp(accepted));
    robot.says(willmsgupd("gone"));
    robot.hears(willmsgresp(accepted));
    falls_silent(robot);
    heir.hears_publish(no_flags, will_id(), "gone");
}

TEST_P(S6_4_Will, b_AnEmptyWilltopicupdDeletesTopicAndMessage) {
    Client& heir = watcher();
    Client& robot = client();
    robot.connects_with_will(topic("will"), "gone", no_flags, no_flags);
    robot.says(empty_willtopicupd());
    robot.hears(willtopicresp(accepted));
    falls_silent(robot);
    Client& other = client();
    other.connects_with_will(topic("will"), "other", no_flags, clean, 1);
    heir.hears_publish(no_flags, will_id(), "other");
    hears_nothing(heir);
}

TEST_P(S6_4_Will, b_ATopicWithoutMessageHasAnEmptyOne) {
    Client& heir = watcher();
    Client& robot = connected(no_flags);
    robot.says(willtopicupd(topic("will")));
    robot.hears(willtopicresp(accepted));
    falls_silent(robot);
    heir.hears_publish(no_flags, will_id(), "");
}

TEST_P(S6_4_Will, b_AMessageWithoutTopicIsNotPublished) {
    Client& heir = watcher();
    Client& robot = client();
    robot.connects_with_will(topic("will"), "gone", no_flags, no_flags);
    robot.says(empty_willtopicupd());
    robot.hears(willtopicresp(accepted));
    robot.says(willmsgupd("a message alone"));
    robot.hears(willmsgresp(accepted));
    falls_silent(robot);
    Client& other = client();
    other.connects_with_will(topic("will"), "other", no_flags, clean, 1);
    heir.hears_publish(no_flags, will_id(), "other");
    hears_nothing(heir);
}

TEST_P(S6_4_Will, ARetainedOneWithoutMessageDeletesWhatIsRetained) {
    Client& heir = watcher();
    retains(heir, topic("will"), "here");
    heir.hears_publish(no_flags, will_id(), "here");
    Client& robot = client();
    robot.connects_with_will(topic("will"), "", retain, clean, 1);
    heir.hears_publish(no_flags, will_id(), "");
    Client& late = connected();
    late.subscribes(topic("will"));
    hears_nothing(late);
}

TEST_P(S6_4_Will, b_UpdatesThatAreNotPossibleAreRefused) {
    Client& robot = connected();
    robot.says(willtopicupd("a/#"));
    robot.hears(willtopicresp(not_supported));
    robot.says(willtopicupd(topic("will"), qos_minus_1));
    robot.hears(willtopicresp(not_supported));
}

TEST_P(S6_4_Will, a_RepeatedUpdatesAreAnsweredAgain) {
    Client& robot = connected();
    for (int i = 0; i < 2; ++i) {
        robot.says(willtopicupd(topic("will")));
        robot.hears(willtopicresp(accepted));
        robot.says(willmsgupd("gone"));
        robot.hears(willmsgresp(accepted));
    }
}

TEST_P(S6_4_Will, g8_UpdatesOfStrangersAreAnsweredByDisconnect) {
    Client& stranger = client();
    stranger.says(willtopicupd(topic("will")));
    stranger.hears(disconnect());
    stranger.says(willmsgupd("gone"));
    stranger.hears(disconnect());
}

}  // namespace
}  // namespace romano::conformance::will_test
