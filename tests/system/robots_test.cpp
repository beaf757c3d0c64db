// Real robots (romano-robot, the controllers of firmware/examples), real brokers, and the
// operator's program.

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "tests/system/broker_fixture.h"
#include "tests/system/metrics_page.h"
#include "tests/system/test_client.h"
#include "tests/temporary_folder.h"

namespace romano::system::robots_test {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

std::string single_spaced(const std::string& line) {
    std::string out;
    for (const char letter : line) {
        if (letter != ' ' || (!out.empty() && out.back() != ' ')) out += letter;
    }
    return out;
}

struct Robots : BrokerFixture {
    Process& start_robot(const std::string& id, int broker, std::vector<std::string> more = {}) {
        std::vector<std::string> arguments{"--id", id, "--broker", addresses.service(broker)};
        arguments.insert(arguments.end(), more.begin(), more.end());
        robots.push_back(std::make_unique<Process>(ROMANO_ROBOT, arguments));
        return *robots.back();
    }
    /// `romano COMMAND -h <broker>`; its exit code, and its output in `said`.
    int romano(int broker, std::vector<std::string> arguments) {
        const std::string service = addresses.service(broker);
        const auto colon = service.find(':');
        arguments.insert(arguments.begin() + 1,
                         {"-h", service.substr(0, colon), "-p", service.substr(colon + 1)});
        Process program(ROMANO_PROGRAM, arguments);
        said = single_spaced(program.rest_of_output());
        const int code = program.wait_for_exit();
        said += program.errors();
        return code;
    }

    std::vector<std::unique_ptr<Process>> robots;
    std::string said;
};

TEST_F(Robots, AreEstablishedListedAndMovedByTheOperator) {
    start_broker(1);
    Process& robot = start_robot("abcd1234", 1);
    EXPECT_NE(robot.wait_for("established"), "");
    EXPECT_EQ(romano(1, {"robots"}), 0);
    EXPECT_THAT(said, HasSubstr("abcd1234 connected r1"));
    EXPECT_EQ(romano(1, {"move", "abcd1234", "front", "100mm"}), 0);
    EXPECT_THAT(robot.wait_for("front"), HasSubstr("abcd1234 front 100 mm (x 100 mm"));
    EXPECT_EQ(romano(1, {"move", "abcd1234", "rotate-left", "90deg"}), 0);
    EXPECT_EQ(romano(1, {"move", "common", "front", "5cm"}), 0);
    EXPECT_THAT(robot.wait_for("front"), HasSubstr("x 100 mm, y 50 mm, heading 90 deg"));
}

TEST_F(Robots, SubscribeAndPublishOnCommand) {
    start_broker(1);
    Process& leader = start_robot("00000001", 1);
    Process& follower = start_robot("00000002", 1);
    ASSERT_NE(leader.wait_for("established"), "");
    ASSERT_NE(follower.wait_for("established"), "");
    EXPECT_EQ(romano(1, {"subscribe-robot", "00000002", "telemetry"}), 0);
    EXPECT_EQ(romano(1, {"request", "00000001", "telemetry", "location"}), 0);
    EXPECT_NE(leader.wait_for("asked to publish `location` on `telemetry`"), "");
    EXPECT_NE(follower.wait_for("sensor data of type 2 on `telemetry`"), "");
    EXPECT_EQ(romano(1, {"request", "00000001", "telemetry", "colour"}), 0);
    EXPECT_NE(follower.wait_for("hears `colour` on `telemetry`"), "");
    EXPECT_EQ(romano(1, {"request", "00000001", "answer", "colour", "--wait", "20"}), 0);
    EXPECT_THAT(said, HasSubstr("(the request's own words: it has no such data)"));
}

TEST_F(Robots, WhatTheNetworkSaysIsOneLineOfPrintableLetters) {
    start_broker(1);
    Process& robot = start_robot("00000001", 1);
    ASSERT_NE(robot.wait_for("established"), "");
    EXPECT_EQ(romano(1, {"request", "00000001", "telemetry", "\x1b[31m\n00000001 established"}), 0);
    EXPECT_THAT(robot.wait_for("asked"), HasSubstr("`\\x1b[31m\\x0a00000001 established`"));
}

TEST_F(Robots, WhatTheOperatorCannotMeanIsOneSentence) {
    start_broker(1);
    EXPECT_EQ(romano(1, {"move", "abcd1234", "front", "100mm"}), 2);
    EXPECT_THAT(said, HasSubstr("no robot abcd1234 is known"));
    EXPECT_EQ(romano(1, {"move", "common", "up", "100mm"}), 2);
    EXPECT_THAT(said, HasSubstr("must be front, back"));
    EXPECT_EQ(romano(1, {"move", "$SYS/brokers/r1", "front", "100mm"}), 2);
    EXPECT_THAT(said, HasSubstr("refused this"));
}

TEST_F(Robots, TheAuthorsFirmwareIsAcknowledgedAndMovedInItsOwnForm) {
    start_broker(1);
    TestClient robot{addresses.client(), addresses.service_endpoint(1), "0433ed81"};
    ASSERT_TRUE(robot.connect());
    ASSERT_TRUE(robot.subscribe("0433ed81", mqttsn::Qos::at_most_once));
    ASSERT_TRUE(robot.subscribe("common", mqttsn::Qos::at_most_once));
    const auto init = robot.register_topic("init_info");
    ASSERT_TRUE(init);
    ASSERT_TRUE(robot.publish(*init, "00433ed81", mqttsn::Qos::at_most_once));
    ASSERT_TRUE(robot.run_until([&] { return !robot.received.empty(); }));
    EXPECT_EQ(robot.received[0].topic, "0433ed81");
    EXPECT_EQ(robot.received[0].data, "ACK");
    EXPECT_EQ(romano(1, {"move", "0433ed81", "front", "500ms"}), 0) << said;
    EXPECT_TRUE(robot.run_until([&] { return robot.received.size() == 2; }));
    EXPECT_EQ(robot.received.back().data, "70401f400001e");
    EXPECT_EQ(romano(1, {"move", "0433ed81", "front", "100mm"}), 2);
    EXPECT_THAT(said, HasSubstr("drives by time"));
}

TEST_F(Robots, CommandsKeepArrivingWhenTheHomeIsKilled) {
    start_member(1);
    start_member(2);
    Process& robot = start_robot("abcd1234", 1);
    Process& other = start_robot("00000002", 2);
    ASSERT_NE(robot.wait_for("established"), "");
    ASSERT_NE(other.wait_for("established"), "");
    EXPECT_EQ(romano(2, {"move", "abcd1234", "front", "1mm"}), 0);
    EXPECT_NE(robot.wait_for("front 1 mm"), "");
    brokers[0]->kill_9();
    for (int i = 2; i < 7; ++i) {
        const std::string amount = std::to_string(i);
        ASSERT_EQ(romano(2, {"move", "abcd1234", "front", amount + "mm"}), 0) << said;
        EXPECT_NE(robot.wait_for("front " + amount + " mm"), "");
    }
    // The heir corrects the list when it next looks at its entries.
    said = "\"home\": \"r1\"";
    for (int i = 0; i < 100 && said.find("\"home\": \"r1\"") != std::string::npos; ++i) {
        ASSERT_EQ(romano(2, {"robots", "--json"}), 0);
    }
    EXPECT_THAT(said, HasSubstr("\"home\": \"r2\""));
    EXPECT_THAT(said, testing::Not(HasSubstr("\"home\": \"r1\"")));
    // The robot never noticed: it was established once.
    robot.signal(SIGTERM);
    EXPECT_THAT(robot.wait_for("1 robots"), HasSubstr("0 connections lost; 6 commands"));
}

TEST_F(Robots, ARobotWhoseHomeDiesBeforeItsRequestIsAnsweredByTheHeir) {
    start_member(1);
    start_member(2);
    // Until the brokers know each other, nobody takes over.
    Process& first = start_robot("00000001", 1);
    ASSERT_NE(first.wait_for("established"), "");
    for (int i = 0; i < 100 && said.find("00000001") == std::string::npos; ++i) {
        ASSERT_EQ(romano(2, {"robots"}), 0);
    }
    Process& robot = start_robot("abcd1234", 1);
    brokers[0]->kill_9();
    EXPECT_NE(robot.wait_for("established"), "");
    EXPECT_EQ(romano(2, {"robots"}), 0);
    EXPECT_THAT(said, HasSubstr("abcd1234 connected r2"));
}

TEST_F(Robots, CommandsWaitForARobotThatStandsStill) {
    start_broker(1);
    Process& robot =
        start_robot("abcd1234", 1, {"--heartbeat", "0.2", "--keep-session", "--keepalive", "60"});
    ASSERT_NE(robot.wait_for("established"), "");
    // Who never sent a heartbeat is missed by nobody.
    for (int i = 0; i < 100 && said.find("s ago") == std::string::npos; ++i) {
        ASSERT_EQ(romano(1, {"robots"}), 0);
    }
    robot.signal(SIGSTOP);
    for (int i = 0; i < 100 && said.find("silent") == std::string::npos; ++i) {
        ASSERT_EQ(romano(1, {"robots"}), 0);
    }
    ASSERT_THAT(said, HasSubstr("abcd1234 silent"));
    EXPECT_EQ(romano(1, {"move", "abcd1234", "front", "1mm"}), 0);
    EXPECT_THAT(said, HasSubstr("abcd1234 is silent: the message waits for it"));
    EXPECT_EQ(romano(1, {"move", "abcd1234", "front", "2mm", "-q", "0"}), 0);
    robot.signal(SIGCONT);
    EXPECT_THAT(robot.wait_for("front"), HasSubstr("front 1 mm"));
    EXPECT_THAT(robot.wait_for("front"), HasSubstr("front 2 mm"));
}

TEST_F(Robots, WhoIsStoppedIsGoneAtOnceAndWithAKeptSessionAway) {
    start_broker(1);
    Process& robot = start_robot("abcd1234", 1, {"--keepalive", "600"});
    Process& keeping = start_robot("00000002", 1, {"--keepalive", "600", "--keep-session"});
    ASSERT_NE(robot.wait_for("established"), "");
    ASSERT_NE(keeping.wait_for("established"), "");
    robot.signal(SIGTERM);
    keeping.signal(SIGINT);
    EXPECT_EQ(robot.wait_for_exit(), 0);
    EXPECT_EQ(keeping.wait_for_exit(), 0);
    // The server looks at its entries once a second; the keep-alive would end in ten minutes.
    said = "abcd1234";
    for (int i = 0; i < 50 && said.find("abcd1234") != std::string::npos; ++i) {
        ASSERT_EQ(romano(1, {"robots"}), 0);
    }
    EXPECT_THAT(said, HasSubstr("00000002 away r1"));
    EXPECT_THAT(said, testing::Not(HasSubstr("abcd1234")));
}

TEST_F(Robots, WhoIsStoppedWhileItsBrokerIsDeadEndsSoon) {
    BrokerProcess& broker = start_broker(1);
    Process& robot = start_robot("abcd1234", 1, {"--keepalive", "600"});
    ASSERT_NE(robot.wait_for("established"), "");
    broker.kill_9();
    robot.signal(SIGTERM);
    EXPECT_EQ(robot.wait_for_exit(10s), 0);
}

class Interrupted : public Robots, public testing::WithParamInterface<std::vector<std::string>> {};

TEST_P(Interrupted, CommandsSayGoodbye) {
    const std::string service = addresses.service(1);
    start_broker(1, {"--metrics", service});
    const auto connected = [&](int sessions) {
        return metrics_come_to_say(addresses.service_endpoint(1),
                                   "romano_sessions{state=\"active\"}", sessions, sessions);
    };
    const auto colon = service.find(':');
    std::vector<std::string> arguments = GetParam();
    arguments.insert(arguments.begin() + 1, {"-h", service.substr(0, colon), "-p",
                                             service.substr(colon + 1), "--keepalive", "600"});
    Process command(ROMANO_PROGRAM, arguments);
    ASSERT_TRUE(connected(1));
    command.signal(SIGTERM);
    command.wait_for_exit();
    EXPECT_TRUE(connected(0));
}

INSTANTIATE_TEST_SUITE_P(
    On, Interrupted,
    testing::Values(std::vector<std::string>{"sub", "-t", "a"},
                    std::vector<std::string>{"pub", "-t", "a", "-m", "b", "--repeat", "1000",
                                             "--repeat-delay", "1"},
                    std::vector<std::string>{"robots", "--follow"},
                    std::vector<std::string>{"move", "--wait", "600", "nobody", "front", "1mm"}),
    [](const auto& test) { return test.param[0]; });

TEST_F(Robots, HundredsLiveInOneProcess) {
    start_member(1);
    start_member(2);
    Process robot_swarm(ROMANO_ROBOT, {"--count", "200", "--id", "00000100", "--broker",
                                       addresses.service(1), "--broker", addresses.service(2)});
    for (int i = 0; i < 200; ++i) ASSERT_NE(robot_swarm.wait_for("established"), "") << i;
    EXPECT_EQ(romano(1, {"robots"}), 0);
    EXPECT_THAT(said, HasSubstr("200 robots"));
    EXPECT_EQ(romano(2, {"move", "common", "front", "1m"}), 0);
    for (int i = 0; i < 200; ++i) ASSERT_NE(robot_swarm.wait_for("front 1000 mm"), "") << i;
}

TEST_F(Robots, ARobotFindsItsBrokerByDiscovery) {
    const std::string group = "225.1.1.1:" + std::to_string(18'000 + addresses.domain());
    start_broker(1, {"--discovery-group", group});
    const std::string service = addresses.service(9);
    Process robot(ROMANO_ROBOT, {"--id", "abcd1234", "--discover", "--group", group, "--local",
                                 service.substr(0, service.find(':'))});
    EXPECT_NE(robot.wait_for("established"), "");
}

TEST_F(Robots, ARobotFindsABrokerThatServesItsOwnMachineAlone) {
    const std::string group = "225.1.1.1:" + std::to_string(18'500 + addresses.domain());
    start_broker(1, {"--discovery-group", group});
    Process robot(ROMANO_ROBOT, {"--id", "abcd1234", "--discover", "--group", group});
    EXPECT_NE(robot.wait_for("established"), "");
}

TEST_F(Robots, WhoFindsNoBrokerSaysWhatToLookAt) {
    const std::string service = addresses.service(9);
    Process finder(ROMANO_ROBOT, {"--discover", "--group", "225.1.1.1:17999", "--local",
                                  service.substr(0, service.find(':')), "--seconds", "6"});
    Process caller(ROMANO_ROBOT, {"--count", "3", "--broker", service, "--seconds", "6"});
    EXPECT_EQ(finder.wait_for_exit(), 0);
    EXPECT_THAT(finder.errors(), HasSubstr("the robot has found no broker within 5 s; is a broker "
                                           "there that answers discovery"));
    EXPECT_EQ(caller.wait_for_exit(), 0);
    EXPECT_THAT(caller.errors(), HasSubstr("3 of 3 robots have found no broker within 5 s; does a "
                                           "broker answer at --broker"));
}

TEST_F(Robots, ARobotThatCannotAskItsGroupSaysSo) {
    Process robot(ROMANO_ROBOT,
                  {"--discover", "--local", "127.0.0.1", "--group", "[ff02::1]:1883"});
    EXPECT_EQ(robot.wait_for_exit(), 2);
    EXPECT_THAT(robot.errors(), HasSubstr("--group '[ff02::1]:1883'"));
}

TEST_F(Robots, WhatARobotCannotBeIsOneSentenceBeforeItStarts) {
    const std::string broker = addresses.service(1);
    const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
        {{"--telemetry", "pose/#"}, "--telemetry 'pose/#': must be a topic's name"},
        {{"--subscribe", "a/#/b"}, "--subscribe 'a/#/b': must be UTF-8 and not empty"},
        {{"--follow", "a+"}, "--follow 'a+': must be UTF-8 and not empty"},
        {{"--every", "2"}, "--every requires --telemetry"},
        {{"--heartbeat", "nan"}, "--heartbeat: Value nan not in range 0 to 3600"},
        {{"--seconds", "nan"}, "--seconds: Value nan not in range 0 to 1e+06"},
        {{"--group", "225.1.1.1:1883"}, "--group requires --discover"},
        {{"--local", "::1"}, "is not of the family of --local '::1'"},
        {{"--key", "/nowhere"}, "--key: /nowhere: cannot be read"},
        {{"--id", "R2"}, "--id 'R2': must be 8 lower-case hexadecimal digits"},
        {{"--id", "fffffffe", "--count", "3"}, "--count '3': from --id fffffffe on there are 2"}};
    for (auto [arguments, sentence] : cases) {
        arguments.insert(arguments.end(), {"--broker", broker});
        Process robot(ROMANO_ROBOT, arguments);
        EXPECT_EQ(robot.wait_for_exit(), 2) << sentence;
        EXPECT_THAT(robot.errors(), HasSubstr(sentence));
        EXPECT_EQ(std::ranges::count(robot.errors(), '\n'), 1) << robot.errors();
    }
    Process seeker(ROMANO_ROBOT, {"--discover", "--group", "127.0.0.1:1883"});
    EXPECT_EQ(seeker.wait_for_exit(), 2);
    EXPECT_THAT(seeker.errors(), HasSubstr("--group '127.0.0.1:1883': is no multicast group"));
    Process carrier(ROMANO_BROKER_ROBOT,
                    {"--id", "abcd1234", "--listen", broker, "--telemetry", "pose/#"});
    EXPECT_EQ(carrier.wait_for_exit(), 2);
    EXPECT_EQ(carrier.next_line(), "") << "nothing serves";
    EXPECT_THAT(carrier.errors(), HasSubstr("--telemetry 'pose/#': must be a topic's name"));
}

TEST_F(Robots, WithoutARomanoServerNobodyIsEstablished) {
    start_broker(1, {"--no-romano"});
    Process& robot = start_robot("abcd1234", 1, {"--seconds", "2"});
    EXPECT_THAT(robot.next_line(), HasSubstr("1 robots, 0 established"));
}

TEST_F(Robots, ARobotThatIsABrokerHeedsRightsAndReadsThemAgainAtSighup) {
    const tests::TemporaryFolder folder;
    const std::string file = folder / "rights";
    std::ofstream(file) << "group plain\ntopic readwrite #\n";
    Process carrier(ROMANO_BROKER_ROBOT,
                    {"--id", "00000002", "--listen", addresses.service(2), "--rights", file});
    ASSERT_NE(carrier.wait_for("00000002 established"), "");
    EXPECT_EQ(romano(2, {"pub", "-t", "pose", "-m", "x", "-q", "1"}), 0) << said;
    std::ofstream(file) << "group plain\ntopic read #\n";
    carrier.signal(SIGHUP);
    for (int i = 0; i < 100 && said.find("not permitted") == std::string::npos; ++i) {
        romano(2, {"pub", "-t", "pose", "-m", "x", "-q", "1"});
    }
    EXPECT_THAT(said, HasSubstr("not permitted"));
}

TEST_F(Robots, ARobotThatIsABrokerServesItselfAndOthersAndOutlivesItsPeer) {
    start_member(1);
    Process carrier(
        ROMANO_BROKER_ROBOT,
        {"--id", "00000002", "--listen", addresses.service(2), "--name", "r2", "--domain",
         std::to_string(addresses.domain()), "--interface", "lo", "--detection-timeout-ms", "300"});
    ASSERT_NE(carrier.wait_for("serving"), "");
    ASSERT_NE(carrier.wait_for("00000002 established"), "");
    Process& guest = start_robot("00000003", 2);
    ASSERT_NE(guest.wait_for("established"), "");
    EXPECT_EQ(romano(1, {"move", "00000002", "front", "1mm"}), 0) << said;
    EXPECT_NE(carrier.wait_for("front 1 mm"), "");
    brokers[0]->kill_9();
    EXPECT_EQ(romano(2, {"move", "00000002,00000003", "front", "2mm"}), 0) << said;
    EXPECT_NE(carrier.wait_for("front 2 mm"), "");
    EXPECT_NE(guest.wait_for("front 2 mm"), "");
}

class Application : public Robots, public testing::WithParamInterface<const char*> {};

TEST_P(Application, EndsWhereItShouldAndDrawsTheTrails) {
    start_broker(1);
    const tests::TemporaryFolder folder;
    EXPECT_EQ(romano(1, {"apply", GetParam(), "-o", folder.path()}), 0) << said;
    std::string file = GetParam();
    std::ranges::replace(file, '-', '_');
    EXPECT_TRUE(std::filesystem::exists(folder / (file + ".csv")));
    EXPECT_TRUE(std::filesystem::exists(folder / (file + ".svg"))) << "is gnuplot installed?";
    EXPECT_THAT(said, testing::AnyOf(HasSubstr(" mm "), HasSubstr(" dBm")));  // how well
}

/// "group-control" is GroupControl.
std::string in_camel_case(const testing::TestParamInfo<const char*>& test) {
    std::string name;
    bool begins = true;
    for (const char* letter = test.param; *letter != '\0'; ++letter) {
        if (*letter != '-') name += begins ? static_cast<char>(std::toupper(*letter)) : *letter;
        begins = *letter == '-';
    }
    return name;
}

INSTANTIATE_TEST_SUITE_P(Of, Application,
                         testing::Values("group-control", "path-copy", "radio-distance"),
                         in_camel_case);

/// Those that start brokers of their own, at addresses and ports of their own: one at a time on a
/// machine.
class ApplicationWithBrokers : public testing::TestWithParam<std::vector<std::string>> {
protected:
    ApplicationWithBrokers()
        : lock_(open("/tmp/romano-test-applications", O_RDWR | O_CREAT | O_CLOEXEC, 0666)) {
        EXPECT_EQ(flock(lock_, LOCK_EX), 0);
    }
    ~ApplicationWithBrokers() override { close(lock_); }

private:
    int lock_;
};

/// What the brokers said, for a run that failed.
std::string traces_in(const std::filesystem::path& folder) {
    std::ostringstream out;
    for (const auto& file : std::filesystem::directory_iterator{folder}) {
        if (file.path().extension() != ".txt") continue;
        out << "--- " << file.path().filename().string() << '\n'
            << std::ifstream{file.path()}.rdbuf();
    }
    return out.str();
}

TEST_P(ApplicationWithBrokers, DoesWhatItShouldAndDrawsIt) {
    const tests::TemporaryFolder folder;
    std::vector<std::string> arguments{"apply",    "-o", folder.path(), "--broker", ROMANO_BROKER,
                                       "--domain", "86", "--network",   "127.77.86"};
    arguments.insert(arguments.begin() + 1, GetParam().begin(), GetParam().end());
    Process program(ROMANO_PROGRAM, arguments);
    const bool done = program.wait_for_exit(std::chrono::minutes{3}) == 0;
    EXPECT_TRUE(done) << program.rest_of_output() << program.errors() << traces_in(folder.path());
    const std::string& file = GetParam()[0];
    EXPECT_TRUE(std::filesystem::exists(folder / (file + ".csv")));
    EXPECT_TRUE(std::filesystem::exists(folder / (file + ".svg"))) << "is gnuplot installed?";
}

INSTANTIATE_TEST_SUITE_P(Of, ApplicationWithBrokers,
                         testing::Values(std::vector<std::string>{"bridge"},
                                         std::vector<std::string>{"roaming", "--brief"}),
                         [](const auto& run) { return run.param[0]; });

class Example : public Robots, public testing::WithParamInterface<const char*> {};

TEST_P(Example, CarriesCommandsOutAndEndsAfterSoMany) {
    start_broker(1);
    const std::string service = addresses.service(1);
    const auto colon = service.find(':');
    Process controller(GetParam(),
                       {"abcd1234", service.substr(0, colon), service.substr(colon + 1), "2"});
    for (int i = 0; i < 100 && said.find("abcd1234") == std::string::npos; ++i) {
        ASSERT_EQ(romano(1, {"robots"}), 0);
    }
    EXPECT_EQ(romano(1, {"move", "abcd1234", "front", "100mm"}), 0);
    EXPECT_THAT(controller.next_line(), HasSubstr("100 mm"));
    EXPECT_EQ(romano(1, {"move", "abcd1234", "rotate-right", "1deg"}), 0);
    EXPECT_NE(controller.next_line(), "");
    EXPECT_EQ(controller.wait_for_exit(), 0);
}

INSTANTIATE_TEST_SUITE_P(In, Example, testing::Values(CONTROLLER_C, CONTROLLER_CPP),
                         [](const auto& test) { return test.index == 0 ? "C" : "Cpp"; });

}  // namespace
}  // namespace romano::system::robots_test
