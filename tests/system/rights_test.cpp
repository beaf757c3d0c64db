// Who may do what, with real brokers and keys: robots do not move each other, an heir says no as
// well, and rights change while brokers run.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <fstream>
#include <string>

#include "tests/system/protected_fleet.h"

namespace romano::system::rights_test {
namespace {

using namespace std::chrono_literals;
using mqttsn::Qos;
using testing::HasSubstr;
using testing::Not;

struct FleetWithRights : ProtectedFleet {
    std::string write_rights(const std::string& text) {
        std::ofstream(file) << text;
        return file;
    }
    std::string usual() {
        EXPECT_EQ(romano({"rights", "usual"}), 0);
        return said;
    }
    bool refuses(int broker, const std::string& deed, int at_least) {
        return metrics_come_to_say(addresses.service_endpoint(broker),
                                   "romano_rights_refusals_total{reason=\"" + deed + "\"}",
                                   at_least);
    }
    int rights_as(const std::string& key, int broker, std::vector<std::string> arguments) {
        const std::string service = addresses.service(broker);
        const auto colon = service.find(':');
        arguments.insert(arguments.begin(), "rights");
        arguments.insert(arguments.end(), {"-h", service.substr(0, colon), "-p",
                                           service.substr(colon + 1), "--key", key});
        return romano(arguments);
    }
    /// The digest and what is said of it.
    int show_rights(int broker) { return rights_as(key_of_anna, broker, {"show"}); }
    std::string file = folder / "rights";
    std::string key_of_anna = keys.own_file("anna", keys::Role::person);
};

TEST_F(FleetWithRights, AStolenRobotMovesNoOther) {
    BrokerProcess& broker = start_protected(1);
    Process robot(ROMANO_ROBOT, {"--key", keys.own_file("00000007", keys::Role::robot), "--broker",
                                 addresses.service(1)});
    ASSERT_THAT(robot.wait_for("established"), HasSubstr("00000007"));
    const std::string stolen = keys.own_file("abcd1234", keys::Role::robot);
    EXPECT_EQ(romano_at(1, {"move", "00000007", "back", "900mm", "--key", stolen}), 2) << said;
    EXPECT_EQ(romano_at(1, {"pub", "-t", "common", "-q", "1", "-m", "8w", "--key", stolen}), 2)
        << said;
    EXPECT_THAT(said, HasSubstr("not permitted"));
    EXPECT_TRUE(refuses(1, "publish", 1));
    const std::string key = keys.own_file("anna", keys::Role::person);
    EXPECT_EQ(romano_at(1, {"move", "00000007", "front", "100mm", "--key", key}), 0) << said;
    EXPECT_THAT(robot.wait_for("mm"), HasSubstr("x 100 mm"));
    EXPECT_THAT(broker.errors(), HasSubstr("refused: robot abcd1234 may not"));
}

TEST_F(FleetWithRights, AnHeirSaysNoAsWell) {
    start_both();
    const auto robot = client_of(1, "abcd1234");
    ASSERT_TRUE(robot->connect());
    ASSERT_TRUE(robot->subscribe("#", Qos::at_least_once));
    const auto anna = client_of(2, "anna");
    ASSERT_TRUE(anna->connect());
    const auto secret = anna->register_topic("plans");
    const auto goal = anna->register_topic("robots/abcd1234/goal");
    const int begun = robot->sessions_begun;
    brokers[0]->kill_9();
    EXPECT_FALSE(robot->register_topic("00000007"));
    ASSERT_TRUE(anna->publish(*secret, "not for robots", Qos::at_least_once));
    ASSERT_TRUE(anna->publish(*goal, "x=1", Qos::at_least_once));
    EXPECT_TRUE(robot->run_until([&] { return !robot->received.empty(); }));
    EXPECT_EQ(robot->received.at(0).data, "x=1");
    EXPECT_EQ(robot->sessions_begun, begun);
    EXPECT_TRUE(refuses(2, "register", 1));
    EXPECT_TRUE(refuses(2, "delivery", 1));
}

TEST_F(FleetWithRights, AreReadAgainAtSighupAndKeptWhenTheyAreWrong) {
    start_protected(1, {"--rights", write_rights(usual())});
    const auto robot = client_of(1, "abcd1234");
    ASSERT_TRUE(robot->connect());
    EXPECT_FALSE(robot->register_topic("lamp"));
    write_rights(usual() + "user abcd1234\ntopic write lamp\n");
    brokers[0]->signal(SIGHUP);
    bool may = false;
    for (int i = 0; i < 500 && !may; ++i) {
        may = robot->register_topic("lamp").has_value();
        if (!may) robot->run_until([] { return false; }, 20ms);
    }
    ASSERT_TRUE(may);
    write_rights(usual() + "user abcd1234\ntopic wirte lamp/#/\n");
    brokers[0]->signal(SIGHUP);
    EXPECT_TRUE(robot->ping());
    EXPECT_TRUE(robot->register_topic("lamp"));
    brokers[0]->signal(SIGTERM);
    EXPECT_EQ(brokers[0]->wait_for_exit(), 0);
    EXPECT_THAT(brokers[0]->errors(), HasSubstr("the rights of before stay"));
}

TEST_F(FleetWithRights, BrokersWithOthersSaySoByName) {
    start_member(1, {"--rights", write_rights(usual())});
    const std::string others = folder / "others";
    std::ofstream(others) << usual() << "user anna\ntopic deny plans\n";
    start_member(2, {"--rights", others});
    expect_both_in_view();
    const auto says = [&](const std::string& words) {
        for (int i = 0; i < 100; ++i) {
            if (show_rights(1) == 0 && said.find(words) != std::string::npos) return true;
        }
        return false;
    };
    EXPECT_TRUE(says("the brokers disagree")) << said;
    EXPECT_THAT(said, HasSubstr("the usual ones"));
    EXPECT_EQ(romano_at(1, {"brokers", "--key", key_of_anna}), 0);
    EXPECT_THAT(said, HasSubstr("the brokers disagree about rights: r1 has '"));
    std::filesystem::copy_file(file, others, std::filesystem::copy_options::overwrite_existing);
    brokers[1]->signal(SIGHUP);
    for (int i = 0; i < 100 && said.find("disagree") != std::string::npos; ++i) show_rights(1);
    EXPECT_THAT(said, Not(HasSubstr("disagree")));
    EXPECT_THAT(brokers[0]->errors(), HasSubstr("the brokers disagree about rights: r1 has '"));
}

TEST_F(FleetWithRights, AreSetForAllBrokersByAnOperatorAndTakenBack) {
    start_both();
    auto robot = client_of(2, "abcd1234");
    ASSERT_TRUE(robot->connect());
    EXPECT_FALSE(robot->register_topic("lamp"));
    write_rights(usual() + "user abcd1234\ntopic write lamp\n");
    EXPECT_EQ(rights_as(key_of_anna, 1, {"set", file}), 0) << said;
    EXPECT_THAT(said, Not(HasSubstr("disagree")));
    EXPECT_TRUE(robot->register_topic("lamp")) << "at the other broker";

    const std::string stolen = keys.own_file("00000007", keys::Role::robot);
    EXPECT_EQ(rights_as(stolen, 1, {"set", file}), 2);
    EXPECT_THAT(said, HasSubstr("refused"));
    EXPECT_EQ(romano({"rights", "set", file}), 2);
    EXPECT_THAT(said, HasSubstr("--key is needed"));
    write_rights("group operators\ntopic readwrite #\ntopic read $SYS/#\n");
    EXPECT_EQ(rights_as(key_of_anna, 1, {"set", file}), 2) << "anna could not do it again";
    EXPECT_THAT(said, HasSubstr("before and afterwards"));
    EXPECT_TRUE(robot->register_topic("lamp"));

    robot.reset();
    brokers[0]->kill_9();
    start_member(1);
    robot = client_of(1, "abcd1234");
    ASSERT_TRUE(robot->connect());
    const auto comes_to_register = [&](bool may) {
        for (int i = 0; i < 500; ++i) {
            if (robot->register_topic("lamp").has_value() == may) return true;
            robot->run_until([] { return false; }, 20ms);
        }
        return false;
    };
    EXPECT_TRUE(comes_to_register(true)) << "who comes back hears of them";
    EXPECT_EQ(rights_as(key_of_anna, 1, {"reset"}), 0) << said;
    EXPECT_TRUE(comes_to_register(false));
}

TEST_F(FleetWithRights, WhatIsWrongWithAFileIsOneSentence) {
    const std::string wrong = write_rights("user anna\ntopci read #\n");
    Process broker(ROMANO_BROKER, {"--listen", addresses.service(1), "--rights", wrong});
    EXPECT_EQ(broker.wait_for_exit(), 2);
    EXPECT_THAT(broker.errors(), HasSubstr("--rights '" + wrong + "': line 2: 'topci' begins"));
    EXPECT_EQ(romano({"rights", "check", wrong}), 1);
    EXPECT_THAT(said, HasSubstr("line 2: 'topci' begins"));
    EXPECT_EQ(romano({"rights", "check", folder / "none"}), 1);
    EXPECT_EQ(romano({"rights", "check", write_rights("user carl\ntopic a\n"), "--keys",
                      keys.broker_folder("r1")}),
              1);
    EXPECT_THAT(said, HasSubstr("carl has rules, and no key"));
    EXPECT_EQ(romano({"rights", "check", write_rights(usual())}), 0) << said;
}

/// Without keys, too: an unmodified client at a plain address.
TEST_F(FleetWithRights, ARightsFileHoldsForPlainClients) {
    start_broker(1, {"--metrics", addresses.service(1), "--rights",
                     write_rights("group plain\ntopic read pose\npattern write pose/%i\n")});
    TestClient client(addresses.client(), addresses.service_endpoint(1), "c1");
    ASSERT_TRUE(client.connect());
    EXPECT_TRUE(client.subscribe("pose", Qos::at_least_once));
    EXPECT_FALSE(client.subscribe("plans", Qos::at_least_once));
    EXPECT_TRUE(client.register_topic("pose/c1"));
    EXPECT_FALSE(client.register_topic("pose/c2"));
    EXPECT_TRUE(refuses(1, "subscribe", 1));
    EXPECT_TRUE(refuses(1, "register", 1));
}

}  // namespace
}  // namespace romano::system::rights_test
