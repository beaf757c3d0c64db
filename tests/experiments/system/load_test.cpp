// `romano load` as people call it, against a real broker: what it says about deliveries, not times.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/experiments/system/processes.h"

namespace romano::experiments::load_test {
namespace {

using ::testing::HasSubstr;

class Load : public ::testing::Test {
protected:
    nlohmann::json load(const std::string& arguments) {
        const Ran ran = run_romano("load -h " + address_ + " -p " + own_port() +
                                   " --warm-up 0.05 --duration 0.2 --json " + arguments);
        EXPECT_EQ(ran.exit_code, 0) << ran.output;
        return nlohmann::json::parse(ran.output);
    }

    const std::string address_ = "127.40.250.1";
    ServingBroker broker_{address_};
};

TEST_F(Load, DeliversEverythingOnceAndInOrderAtEachQos) {
    for (const char* qos : {"0", "1", "2"}) {
        for (const char* sockets : {"", " --one-socket"}) {
            const auto figures =
                load(std::string{"--publishers 3 --subscribers 6 --topics 3 --in-flight 6 -q "} +
                     qos + sockets);
            EXPECT_GT(figures.at("published_messages"), 0);
            EXPECT_EQ(figures.at("delivered"), 2 * figures.at("published_messages").get<int>());
            EXPECT_EQ(figures.at("lost"), 0);
            EXPECT_EQ(figures.at("duplicates"), 0);
            EXPECT_EQ(figures.at("out_of_order"), 0);
            EXPECT_EQ(figures.at("unacknowledged_messages"), 0);
        }
    }
}

TEST_F(Load, KeepsToItsRate) {
    const auto figures = load("--rate 500 --payload 100");
    // 0.25 seconds, or more on a machine that has other things to do.
    EXPECT_GE(figures.at("published_messages"), 125);
    EXPECT_LT(figures.at("published_messages"), 2500);
    EXPECT_EQ(figures.at("lost"), 0);
}

TEST(LoadByCell, OneDatagramIsHeardByAllSubscribers) {
    const std::string address = "127.40.250.2";
    const std::string group = "239.40.250.2:" + own_port();
    const ServingBroker broker{address, {"--cell-group", group}};
    // At QoS 1 listeners take up to 50 ms to answer, and who has not answered is sent unicasts.
    for (const char* how : {"-q 0 --in-flight 1 --duration 0.2", "-q 1 --rate 5 --duration 1"}) {
        const Ran ran =
            run_romano("load -h " + address + " -p " + own_port() +
                       " --warm-up 0 --json --subscribers 10 --cell-group " + group + " " + how);
        ASSERT_EQ(ran.exit_code, 0) << ran.output;
        const auto figures = nlohmann::json::parse(ran.output);
        EXPECT_GT(figures.at("delivered"), 0);
        EXPECT_EQ(figures.at("lost"), 0);
        EXPECT_EQ(figures.at("duplicates"), 0);
        EXPECT_GE(figures.at("deliveries_by_cell"), figures.at("delivered").get<int>() / 2);
    }
}

TEST(LoadByCell, AGroupThatCannotBeIsOneSentence) {
    for (const char* group : {"127.0.0.1:5", "239.1.1.1:0", "[ff05::1]:1884", "nonsense"}) {
        const Ran ran = run_romano(std::string{"load -h 127.40.250.3 --cell-group "} + group);
        EXPECT_EQ(ran.exit_code, 2);
        EXPECT_THAT(ran.output, HasSubstr(std::string{"--cell-group `"} + group + "`: "));
        EXPECT_EQ(std::count(ran.output.begin(), ran.output.end(), '\n'), 1) << ran.output;
    }
}

TEST_F(Load, TellsPeopleTheSameInAFewLines) {
    const Ran ran = run_romano("load -h " + address_ + " -p " + own_port() +
                               " --warm-up 0 --duration 0.1 -q 1 --in-flight 2");
    EXPECT_EQ(ran.exit_code, 0);
    for (const char* word :
         {"throughput", "latency", "acknowledgement", "lost", "acknowledged", "this generator"}) {
        EXPECT_THAT(ran.output, HasSubstr(word));
    }
}

TEST(LoadOnABrokerWithoutRoom, SaysSoAndEnds) {
    const ServingBroker broker("127.40.250.2", {"--max-topics", "1"});
    const Ran ran = run_romano("load -h 127.40.250.2 -p " + own_port() +
                               " --publishers 1 --subscribers 1 --topics 3 --rate 10");
    EXPECT_EQ(ran.exit_code, 2);
    EXPECT_THAT(ran.output, HasSubstr("the broker has no room for a subscription or a topic of"));
}

TEST(LoadThatMakesNoSense, IsRefusedInOneSentence) {
    const Ran endless = run_romano("load --subscribers 0");
    EXPECT_EQ(endless.exit_code, 2);
    EXPECT_THAT(endless.output, HasSubstr("nothing comes back that would turn the closed loop"));
    const Ran nameless = run_romano("load --topic 'a/#'");
    EXPECT_EQ(nameless.exit_code, 2);
    EXPECT_THAT(nameless.output, HasSubstr("--topic `a/#`: must be a topic name"));
    const Ran reserved = run_romano("load --topic '$SYS/a'");
    EXPECT_EQ(reserved.exit_code, 2);
    EXPECT_THAT(reserved.output, HasSubstr("--topic `$SYS/a`: topics that begin with '$'"));
}

TEST(LoadWithoutABroker, SaysSoInOneSentence) {
    const Ran ran = run_romano("load -h 127.40.250.9 -p 9 --broker-timeout 0.2");
    EXPECT_EQ(ran.exit_code, 2);
    EXPECT_THAT(ran.output, HasSubstr("no broker serves at 127.40.250.9:9: nobody listens there"));
}

}  // namespace
}  // namespace romano::experiments::load_test
