// Sections 6.11, 6.12 and 6.14: keep-alive, DISCONNECT, and what a stranger hears.

#include <thread>

#include "tests/conformance/suite.h"

namespace romano::conformance::keep_alive_test {
namespace {

CONFORMANCE_SUITE(S6_11_KeepAlive, PatientSuite);

TEST_P(S6_11_KeepAlive, a_PingreqIsAnsweredByPingresp) {
    Client& robot = connected();
    robot.says({0x02, 0x16});
    robot.hears({0x02, 0x17});
}

TEST_P(S6_11_KeepAlive, g9_PingreqOfAnActiveClientMayCarryItsId) {
    Client& robot = connected();
    robot.says(pingreq(robot.id));
    robot.hears(pingresp());
}

TEST_P(S6_11_KeepAlive, g9_PingreqWithAnotherClientIdIsAStrangers) {
    Client& robot = connected();
    robot.says(pingreq(unique("nobody")));
    robot.hears(disconnect());
}

TEST_P(S6_11_KeepAlive, g9_NobodyTakesAnActiveSessionOverByPingreq) {
    Client& robot = connected();
    Client& other = client();
    other.says(pingreq(robot.id));
    other.hears(disconnect());
    robot.says(pingreq());
    robot.hears(pingresp());
}

TEST_P(S6_11_KeepAlive, b_ASilentClientIsProbedAndThenLost) {  // G6
    Client& robot = connected(clean, 1);
    robot.hears(pingreq());
    hears_nothing(robot);
    Client& watcher = connected();
    Client& late = client();
    const unsigned id = watcher.subscribes(topic("will"));
    late.connects_with_will(topic("will"), "time has passed", no_flags, clean, 1);
    watcher.hears_publish(no_flags, id, "time has passed");
    robot.says(pingreq());
    robot.hears(disconnect());  // it must connect again
}

TEST_P(S6_11_KeepAlive, s6_14_AnyMessageCountsAsLife) {
    Client& robot = connected(clean, 2);
    const unsigned id = robot.registers(topic());
    const auto end = std::chrono::steady_clock::now() + 4s;
    while (std::chrono::steady_clock::now() < end) {
        robot.says(publish(qos1, id, 9, "x"));
        robot.hears_in_time(puback(id, 9));  // never DISCONNECT
        std::this_thread::sleep_for(100ms);
    }
}

TEST_P(S6_11_KeepAlive, AnAnsweredProbeIsLife) {
    Client& robot = connected(clean, 4);
    robot.hears(pingreq());
    robot.says(pingresp());  // with 2 s left of the 6 s that are tolerated
    Client& watcher = connected();
    Client& late = client();
    const unsigned id = watcher.subscribes(topic("will"));
    late.connects_with_will(topic("will"), "3 s have passed", no_flags, clean, 2);
    watcher.hears_publish(no_flags, id, "3 s have passed");
    robot.says(pingreq());
    robot.hears(pingresp());
}

TEST_P(S6_11_KeepAlive, Duration0IsNotSupervised) {
    Client& robot = connected(clean, 0);
    Client& watcher = connected();
    Client& late = client();
    const unsigned id = watcher.subscribes(topic("will"));
    late.connects_with_will(topic("will"), "time has passed", no_flags, clean, 1);
    watcher.hears_publish(no_flags, id, "time has passed");
    hears_nothing(robot);  // no probe
    robot.says(pingreq());
    robot.hears(pingresp());
}

CONFORMANCE_SUITE(S6_12_Disconnect, PatientSuite);

TEST_P(S6_12_Disconnect, a_IsAnsweredByDisconnect) {
    Client& robot = connected();
    robot.says({0x02, 0x18});
    robot.hears({0x02, 0x18});
}

TEST_P(S6_12_Disconnect, g28_Duration0IsAPlainOne) {
    Client& robot = connected();
    robot.says(disconnect_for(0));
    robot.hears(disconnect());
    robot.says(pingreq());
    robot.hears(disconnect());  // no sleeper's session
}

TEST_P(S6_12_Disconnect, ARepeatedOneIsAnsweredAgain) {
    Client& robot = connected();
    robot.disconnects();
    robot.says(disconnect());
    robot.hears(disconnect());
}

TEST_P(S6_12_Disconnect, g8_RequestsOfStrangersAreAnsweredByIt) {
    Client& stranger = client();
    for (const Octets& request :
         {publish(no_flags, 1, 0, "x"), publish(qos1, 1, 9, "x"), publish(qos2, 1, 9, "x"),
          pubrel(9), subscribe(no_flags, 9, topic()), unsubscribe(no_flags, 9, topic()),
          register_topic(0, 9, topic()), pingreq(), pingreq("nobody"), disconnect(),
          disconnect_for(10)}) {
        SCOPED_TRACE(describe(request));
        stranger.says(request);
        stranger.hears(disconnect());
    }
}

TEST_P(S6_12_Disconnect, g8_AnswersOfStrangersAreNotAnswered) {
    Client& stranger = client();
    for (const Octets& answer : {puback(1, 9), pubrec(9), pubcomp(9), regack(1, 9, accepted),
                                 pingresp(), suback(no_flags, 1, 9), unsuback(9)}) {
        SCOPED_TRACE(describe(answer));
        stranger.says(answer);
        hears_nothing(stranger);
    }
}

TEST_P(S6_12_Disconnect, AfterItNothingIsDelivered) {
    Client& robot = connected();
    robot.subscribes(topic());
    robot.disconnects();
    Client& publisher = connected();
    publisher.publishes(publisher.registers(topic()), "x", 1);
    hears_nothing(robot);
}

}  // namespace
}  // namespace romano::conformance::keep_alive_test
