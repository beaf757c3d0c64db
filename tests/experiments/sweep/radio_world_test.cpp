// A cell whose robots are on modelled radio: what the channel carries, that a seed is a run, that a
// broker's death is survived there, and what cannot be.

#include "experiments/sweep/radio_world.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/experiments/sweep/ran_cell.h"

namespace romano::experiments::radio_world_test {
namespace {

constexpr const char* small =
    "world = \"radio\"\npattern = \"commands\"\nduration = 4\nfault_after = "
    "1\n"
    "broker_options = [\"--profile\", \"wifi\"]\n";

struct Ran : RanCell {
    explicit Ran(const std::string& text) : RanCell(text, make_radio_world) {}
};

RunRow at_300_per_s(int brokers) {
    return Ran(std::string{small} +
               "drain = 1\n[axes]\nrouter_baud = 230400\nrobots = 6\nqos = 0\nrate = 300\nbrokers "
               "= " +
               std::to_string(brokers) + "\n")
        .row;
}

TEST(RadioCell, CarriesWhatItsChannelCarriesAndTwoCellsTwice) {
    const RunRow one = at_300_per_s(1);
    ASSERT_EQ(one.status, "ok");
    ASSERT_TRUE(one.delivery_ratio);
    EXPECT_LT(*one.delivery_ratio, 0.95) << "a cell carries 211 messages a second";
    const RunRow two = at_300_per_s(2);
    ASSERT_EQ(two.status, "ok");
    EXPECT_GE(two.delivery_ratio, 0.99);
}

TEST(RadioCell, IsTheSameRunForTheSameSeedAndSurvivesItsBroker) {
    const std::string text =
        std::string{small} +
        "[axes]\nrouter_baud = 230400\nbrokers = 2\nrobots = 4\nrate = 20\nqos = \"0+1+2\"\n"
        "fault = \"kill-home\"\n";
    const Ran one(text);
    ASSERT_EQ(one.row.status, "ok");
    EXPECT_EQ(one.row.acknowledged_but_lost_qos1, 0);
    EXPECT_EQ(one.row.acknowledged_but_lost_qos2, 0);
    EXPECT_EQ(one.row.connects_after_fault, 0);
    EXPECT_GE(one.row.delay_p50_ms, 10) << "two UARTs and a hop on the air";
    const Ran again(text);
    EXPECT_EQ(to_csv(one.row), to_csv(again.row));
    EXPECT_EQ(one.samples(), again.samples());
    EXPECT_NE(one.samples(), Ran(text + "seed = 2\n").samples());
}

TEST(RadioCell, IsQuickerOnQuickerLines) {
    const auto delay_ms = [](const std::string& lines) {
        return *Ran(std::string{small} + "[axes]\nrobots = 1\nrate = 10\nqos = 0\n" + lines)
                    .row.delay_p50_ms;
    };
    EXPECT_NEAR(delay_ms("router_baud = 115200\n"), 17.8, 0.9);
    EXPECT_NEAR(delay_ms("router_baud = 230400\n"), 13.2, 0.7);
    EXPECT_NEAR(delay_ms("router_baud = \"none\"\nrobot_baud = \"none\"\n"), 3.6, 0.5);
}

/// What QoS 1 costs between brokers is the way there and back before the PUBACK, and what robots
/// of another broker hear goes that way.
TEST(RadioCell, HasTheBackboneThatItsAxisSays) {
    const auto ran = [](const char* backbone) {
        return Ran("world = \"radio\"\npattern = \"commands\"\nduration = 10\nfault_after = 2\n"
                   "start_within = 60\nbroker_options = [\"--profile\", \"mesh\"]\n[axes]\nbrokers "
                   "= 3\nrobots = 6\n"
                   "rate = 5\nqos = 1\nbackbone = \"" +
                   std::string{backbone} + "\"\n")
            .row;
    };
    const RunRow wire = ran("wire");
    const RunRow wifi = ran("wifi");
    const RunRow radio = ran("radio");
    for (const RunRow& row : {wire, wifi, radio}) {
        ASSERT_EQ(row.status, "ok");
        EXPECT_EQ(row.delivery_ratio, 1) << row.cell.backbone;
        EXPECT_EQ(row.broken_promises(), "") << row.cell.backbone;
    }
    EXPECT_GT(*wifi.delay_p50_ms, *wire.delay_p50_ms + 1);
    EXPECT_GT(*radio.delay_p50_ms, *wifi.delay_p50_ms + 2) << "some frames on the air";
}

/// At 30 m they hear each other, at 300 m not.
TEST(RadioCell, BrokersOutOfEachOthersRangeDoNotFindEachOther) {
    const std::string far =
        "world = \"radio\"\npattern = \"commands\"\nduration = 4\nfault_after = 1\n"
        "start_within = 60\nrouter_distance_m = 300\n"
        "broker_options = [\"--profile\", \"mesh\"]\n[axes]\nbrokers = 2\nrobots = 2\n";
    EXPECT_EQ(Ran(far).row.status, "ok");
    EXPECT_NE(Ran(far + "backbone = \"radio\"\n").row.status, "ok");
}

TEST(RadioCell, MoreRobotsThanARouterCanHaveAreRefused) {
    const Sweep sweep = parse_sweep("world = \"radio\"\n[axes]\nrobots = 2000\n", "try.toml");
    try {
        check_radio(sweep.settings, sweep.cells);
        ADD_FAILURE() << "accepted";
    } catch (const SweepError& error) {
        EXPECT_STREQ(error.what(),
                     "`world = \"radio\"`: 2000 robots are too many for one cell: at most 1000");
    }
}

}  // namespace
}  // namespace romano::experiments::radio_world_test
