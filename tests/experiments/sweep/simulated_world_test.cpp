// A cell in a simulated world: the same run for the same seed, what each fault does, what a link
// does, and what such a world cannot measure.

#include "experiments/sweep/simulated_world.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/experiments/sweep/ran_cell.h"

namespace romano::experiments::simulated_world_test {
namespace {

using ::testing::HasSubstr;

constexpr const char* small = "world = \"simulated\"\nduration = 3\nfault_after = 1\npause = 0.5\n";

struct Ran : RanCell {
    explicit Ran(const std::string& text)
        : RanCell(text, [](const SweepSettings& settings, const Cell& cell) {
              return std::make_unique<SimulatedWorld>(settings, cell);
          }) {}
};

std::string refusal_of(const std::string& broker_options) {
    try {
        check_simulated_broker_options(
            parse_sweep(std::string{small} + "broker_options = " + broker_options + "\n[axes]",
                        "try.toml")
                .settings);
    } catch (const SweepError& error) {
        return error.what();
    }
    return "accepted";
}

TEST(SimulatedCell, IsTheSameRunForTheSameSeed) {
    const std::string text = std::string{small} +
                             "client_loss_percent = 2\nprobe = 100\n"
                             "[axes]\nbrokers = 3\nrobots = 6\nrate = 10\nqos = \"0+1+2\"\n"
                             "fault = \"kill-leader\"\n";
    const Ran one(text);
    const Ran again(text);
    const Ran another(text + "seed = 2\n");
    EXPECT_EQ(to_csv(one.row), to_csv(again.row));
    EXPECT_EQ(one.samples(), again.samples());
    EXPECT_NE(one.samples(), another.samples());
}

TEST(SimulatedCell, LeavesEmptyWhatOnlyProcessesHave) {
    const RunRow row = Ran(std::string{small} + "[axes]\nbrokers = 2\nrobots = 4\n").row;
    EXPECT_EQ(row.status, "ok");
    EXPECT_EQ(row.started_utc, "");
    EXPECT_FALSE(row.broker_cpu_percent_mean);
    EXPECT_FALSE(row.broker_rss_peak_mib_max);
    EXPECT_GT(row.interbroker_octets_per_s, 0);
    EXPECT_EQ(row.publish_lag_max_ms, 0);
}

TEST(SimulatedCell, OfOneBrokerDeliversEverything) {
    const RunRow row =
        Ran(std::string{small} + "[axes]\nbrokers = 1\nrobots = 4\nrate = 10\nqos = \"0+1+2\"\n")
            .row;
    EXPECT_EQ(row.status, "ok");
    EXPECT_EQ(row.delivery_ratio, 1);
    EXPECT_GT(row.published, 100);
}

// From the publisher to its broker, and from the broker to the subscriber.
TEST(SimulatedCell, HasTheDelayOfItsLinks) {
    const RunRow row =
        Ran(std::string{small} + "client_delay_ms = 20\n[axes]\nbrokers = 1\nrobots = 4\nqos = 0\n")
            .row;
    EXPECT_NEAR(row.delay_min_ms.value_or(0), 40, 0.1);
    EXPECT_NEAR(row.delay_max_ms.value_or(0), 40, 0.1);
}

// Nothing overtakes on one wire, between brokers neither.
TEST(SimulatedCell, LosesNothingOnLinksThatLoseNothing) {
    const RunRow row = Ran(std::string{small} +
                           "wire_delay_ms = [0, 2]\n"
                           "[axes]\nbrokers = 2\nrobots = 10\nrate = 100\nqos = 0\n")
                           .row;
    EXPECT_EQ(row.delivery_ratio, 1);
    EXPECT_EQ(row.out_of_order_qos0, 0);
}

// Each message of QoS 0 has two links to pass.
TEST(SimulatedCell, LosesOnItsLinksWhatNobodyRepeats) {
    const RunRow row =
        Ran("world = \"simulated\"\nduration = 100\nclient_loss_percent = 20\nretry = 0.1\n"
            "broker_options = [\"--retry-ms\", \"100\"]\n[axes]\nbrokers = 1\nrobots = 5\nrate = "
            "2\nqos = \"0+1\"\n")
            .row;
    EXPECT_NEAR(row.delivery_ratio_qos0.value_or(0), 0.64, 0.06);
    EXPECT_EQ(row.delivery_ratio_qos1, 1);
}

TEST(SimulatedCell, TakesOverWithinTheDetectionTimeOfItsProfile) {
    const auto failover_with = [](const std::string& options) {
        return Ran(std::string{small} + "probe = 200\nbroker_options = " + options +
                   "\n[axes]\nbrokers = 3\nrobots = 3\nfault = \"pause\"\n")
            .row.failover_probe_ms.value_or(0);
    };
    EXPECT_NEAR(failover_with("[]"), 50, 25);
    EXPECT_NEAR(failover_with("[\"--profile\", \"wifi\"]"), 500, 100);
}

struct SimulatedCellWithA : ::testing::TestWithParam<Fault> {};

TEST_P(SimulatedCellWithA, FaultKeepsWhatThreeBrokersPromised) {
    const RunRow row =
        Ran(std::string{small} + "[axes]\nbrokers = 3\nrobots = 6\nrate = 20\nqos = \"1+2\"\n" +
            "fault = \"" + std::string{name_of(GetParam())} + "\"\n")
            .row;
    EXPECT_EQ(row.status, "ok");
    EXPECT_EQ(row.broken_promises(), "");
    EXPECT_EQ(row.delivery_ratio, 1);
    EXPECT_GT(row.acknowledged, 100);
    EXPECT_GT(row.strikes, 0);
    EXPECT_EQ(row.failover_recovered_clients, row.failover_clients);
    EXPECT_EQ(row.connects_after_fault, 0);
    EXPECT_EQ(row.registers_after_fault, 0);
    EXPECT_EQ(row.subscribes_after_fault, 0);
}

INSTANTIATE_TEST_SUITE_P(Each, SimulatedCellWithA,
                         ::testing::Values(Fault::kill_leader, Fault::kill_home, Fault::pause,
                                           Fault::pause_leader, Fault::cut, Fault::all_but_one,
                                           Fault::rolling_restart, Fault::rolling_kill),
                         [](const auto& test) {
                             std::string name{name_of(test.param)};
                             std::erase(name, '-');
                             return name;
                         });

struct SimulatedCellOf : ::testing::TestWithParam<const char*> {};

TEST_P(SimulatedCellOf, EachElectorAndDetectorFindsANewLeader) {
    const RunRow row = Ran(std::string{small} +
                           "[axes]\nbrokers = 3\nrobots = 3\nrate = 10\n"
                           "fault = \"kill-leader\"\n" +
                           GetParam())
                           .row;
    EXPECT_EQ(row.status, "ok");
    EXPECT_TRUE(row.without_leader_ms);
    EXPECT_EQ(row.failover_recovered_clients, row.failover_clients);
}

INSTANTIATE_TEST_SUITE_P(Kind, SimulatedCellOf,
                         ::testing::Values("elector = \"raft\"", "elector = \"bully\"",
                                           "detector = \"phi-accrual\"", "detector = \"fixed\"",
                                           "acks = \"all\""));

TEST(SimulatedBrokers, TakeTheOptionsThatTheirCoresHave) {
    EXPECT_EQ(refusal_of("[\"--profile\", \"mesh\", \"--detection-timeout-ms=9000\"]"), "accepted");
}

TEST(SimulatedBrokers, RefuseByNameWhatNeedsAMachine) {
    const std::string why =
        " means nothing in a simulated world, which has no machine; leave it out, or set `world = "
        "\"processes\"`";
    EXPECT_EQ(refusal_of("[\"--realtime\"]"), "`broker_options`: --realtime" + why);
    EXPECT_EQ(refusal_of("[\"--store\", \"/tmp/x\"]"), "`broker_options`: --store" + why);
    EXPECT_EQ(refusal_of("[\"--metrics=127.0.0.1:9883\"]"), "`broker_options`: --metrics" + why);
    EXPECT_THAT(refusal_of("[\"--profile=moon\"]"), HasSubstr("--profile 'moon'"));
    EXPECT_THAT(refusal_of("[\"--moon\"]"), HasSubstr("--moon"));
}

}  // namespace
}  // namespace romano::experiments::simulated_world_test
