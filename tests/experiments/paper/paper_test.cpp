// The paper's experiments on the modelled cell: what comes out, how it is judged, and that runs go
// on where they were interrupted.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "experiments/paper/backbone.h"
#include "experiments/paper/broadcast.h"
#include "experiments/paper/energy.h"
#include "experiments/paper/many_cells.h"
#include "experiments/paper/moves.h"
#include "experiments/paper/paper_plan.h"
#include "experiments/paper/paper_run.h"
#include "experiments/paper/statements.h"
#include "experiments/process/separate_runs.h"
#include "tests/temporary_folder.h"

namespace romano::experiments::paper_test {
namespace {

TEST(PaperRun, TwoHundredMessagesASecondComeThroughAFastLineAndNotThroughASlowOne) {
    const DeliveryRun fast = delivery_run({.router_baud = 230'400}, 200, 1'000);
    EXPECT_GE(fast.delivered, 995U);
    EXPECT_FALSE(fast.overflow_after);
    const DeliveryRun slow = delivery_run({.router_baud = 115'200}, 200, 1'500);
    EXPECT_LT(slow.delivered, 1'400U);
    ASSERT_TRUE(slow.overflow_after);
    EXPECT_NEAR(static_cast<double>(*slow.overflow_after), 500 / (1 - 109.7 / 200), 60);
    EXPECT_LE(slow.delivered_if_it_stops, *slow.overflow_after);
    ASSERT_TRUE(slow.carried_per_s);
    EXPECT_NEAR(*slow.carried_per_s, 109.7, 1.5);
}

TEST(PaperRun, ASeedGivesTheSameDelaysAgain) {
    const PaperCell cell{.robots = 3, .seed = 5};
    const auto means_of = [&] {
        std::vector<double> means;
        for (const RobotDelay& robot : delay_run(cell, 40)) means.push_back(robot.mean);
        return means;
    };
    const auto delays = means_of();
    ASSERT_EQ(delays.size(), 3U);
    EXPECT_NEAR(delays[0], 17.8, 1);
    EXPECT_NEAR(delays[2] - delays[1], 9.1, 0.5);
    EXPECT_EQ(means_of(), delays);
}

constexpr std::size_t broadcasts = 20;

TEST(Broadcast, AtQos0TheLastOf50RobotsHearsAMessageNoMuchLaterThanASingleOne) {
    const auto run = [](std::size_t robots, Way way) {
        return broadcast_run(robots, mqttsn::Qos::at_most_once, way, broadcasts, 1);
    };
    const BroadcastRun one = run(1, Way::unicast);
    const BroadcastRun fifty = run(50, Way::cell);
    EXPECT_EQ(one.heard, 1);
    EXPECT_GE(fifty.heard, 0.95) << "a broadcast frame is sent once";
    EXPECT_LE(fifty.last_ms, 1.5 * one.last_ms);
}

TEST(Broadcast, AtQos1EachOf50RobotsHasAMessageInThreeTimesTheUnicastTimeOfTen) {
    const auto run = [](std::size_t robots, Way way) {
        return broadcast_run(robots, mqttsn::Qos::at_least_once, way, broadcasts, 1);
    };
    const BroadcastRun one = run(1, Way::unicast);
    const BroadcastRun ten = run(10, Way::unicast);
    const BroadcastRun fifty = run(50, Way::cell);
    EXPECT_EQ(ten.heard, 1);
    EXPECT_EQ(fifty.heard, 1);
    EXPECT_GE(ten.last_ms, one.last_ms + 9 * 8) << "one after the other";
    EXPECT_LE(fifty.last_ms, 3 * ten.last_ms);
    EXPECT_LT(fifty.air_ms / 50, ten.air_ms / 10);
}

const Statement& statement_about(const std::vector<Statement>& statements,
                                 const std::string& what) {
    const auto found = std::ranges::find(statements, what, &Statement::what);
    if (found == statements.end()) throw std::runtime_error("nobody states " + what);
    return *found;
}

TEST(PaperStatements, ATenthMoreOrLessIsWithinAndElseTheReasonIsSaid) {
    FiguresByBaud figures;
    figures[115'200].delay[2] = {{17, 18.5, 20}, {28, 30, 32}};
    const auto statements = statements_of(figures);
    ASSERT_EQ(statements.size(), 2U);
    EXPECT_EQ(statements[0].findings.at(0).verdict, "within 10 %");  // of 20 ms
    EXPECT_EQ(statements[1].findings.at(0).compared, 11.5);          // not 8 ms
    EXPECT_EQ(statements[1].findings.at(0).verdict,
              "one more message waits: the radio carries 87/s (11.5 ms a message)");
}

TEST(PaperStatements, AReasonIsComputedFromTheRunsThatItExplains) {
    const DeliveryRun run{.sent = 5'000,
                          .delivered = 4'000,
                          .delivered_if_it_stops = 2'130,
                          .given_up_on_air = 3,
                          .overflow_after = 2'140,
                          .carried_per_s = 210};
    FiguresByBaud figures;
    figures[230'400].delivery.emplace(300, figures_of({run, run}));
    const auto statements = statements_of(figures);
    const Statement& least = statement_about(statements, "least delivery at 300/s");
    ASSERT_EQ(least.findings.size(), 2U);  // goes on, stops
    EXPECT_EQ(least.findings[0].compared, 80);
    EXPECT_EQ(least.findings[0].verdict,
              "2 of 2 runs overflowed: the radio carries 210/s (4.8 ms a message), also after the "
              "queue is full");
    EXPECT_EQ(least.findings[1].verdict, "within 10 %");  // 42.6 of 44
    const Statement& most = statement_about(statements, "most delivery at 300/s");
    EXPECT_EQ(most.findings.at(0).verdict,
              "2 of 2 runs overflowed: the radio carries 210/s (4.8 ms a message); for the paper's "
              "a queue would have to hold 1500");
}

TEST(PaperStatements, ABoundHoldsFromTheNumberOn) {
    FiguresByBaud figures;
    figures[230'400].delivery.emplace(50, figures_of({{.sent = 1'000, .delivered = 995}}));
    figures[230'400].delivery.emplace(
        75, figures_of({{.sent = 1'000, .delivered = 994, .given_up_on_air = 6}}));
    const auto statements = statements_of(figures);
    EXPECT_EQ(statement_about(statements, "least delivery at 50/s").findings.at(0).verdict,
              "holds");
    EXPECT_EQ(statement_about(statements, "least delivery at 75/s").findings.at(0).verdict,
              "no run overflowed; 6 frames were given up on the air");
}

TEST(SeparateRuns, GoOnWhereTheyWereInterrupted) {
    const tests::TemporaryFolder folder;
    const SeparateRun one{"one", [] { return std::string{"1\n"}; }};
    const SeparateRun broken{"two", []() -> std::string { throw std::runtime_error("no"); }};
    const SeparateRun two{"two", [] { return std::string{"2\n"}; }};
    std::vector<std::string> ran;
    const auto note = [&](const SeparateRun& run) { ran.push_back(run.name); };
    EXPECT_THROW(do_runs({one, broken}, folder.path(), 1, note), std::runtime_error);
    EXPECT_FALSE(is_done(two, folder.path()));
    do_runs({one, two}, folder.path(), 2, note);
    EXPECT_EQ(ran, (std::vector<std::string>{"one", "two"}));
    EXPECT_EQ(outcome_of("two", folder.path()), "2\n");
}

/// Two clusters on two cores make each other late.
TEST(SeparateRuns, OneInRealTimeHasTheMachineToItself) {
    const tests::TemporaryFolder folder;
    /// Says that it is there, and waits for the other one.
    const auto meets = [&](const std::string& self, const std::string& other) {
        std::ofstream(folder / self).flush();
        const auto limit = std::chrono::steady_clock::now() + std::chrono::milliseconds{300};
        while (std::chrono::steady_clock::now() < limit) {
            if (std::filesystem::exists(folder / other)) return std::string{"together"};
        }
        return std::string{"alone"};
    };
    const SeparateRun before{"before", [&] { return meets("a", "b"); }};
    const SeparateRun real{"real", [&] { return meets("b", "c"); }, true};
    const SeparateRun after{"after", [&] { return meets("c", "d"); }};
    do_runs({before, real, after}, folder.path(), 2, [](const SeparateRun&) {});
    EXPECT_EQ(outcome_of("before", folder.path()), "alone");
    EXPECT_EQ(outcome_of("real", folder.path()), "alone");
}

TEST(PaperPlan, ImpossibleChannelsAndBaudRatesGetOneSentence) {
    EXPECT_FALSE(problem_with(PaperPlan{}));
    EXPECT_EQ(problem_with({.router_bauds = {115'200, 0}}),
              "a UART of 0 baud cannot be: give 1200 to 10000000 baud, or none");
    EXPECT_EQ(problem_with({.channel = 10}),
              "channel 10 does not exist: IEEE 802.15.4 at 2.4 GHz has channels 11 to 26");
}

TEST(Energy, ARadioThatSendsTakesMoreThanOneThatListens) {
    const Transceiver cc2538;
    EXPECT_DOUBLE_EQ(energy_j(cc2538, 10, 0), 0.6);    // 3 V, 20 mA
    EXPECT_DOUBLE_EQ(energy_j(cc2538, 10, 10), 0.72);  // 24 mA
}

TEST(ManyCells, TwoCarryWhatIsTooMuchForOne) {
    const CellsRun one = cells_run({.brokers = 1}, 300, 900);
    EXPECT_NEAR(one.delivered_per_s, 211, 5);
    const CellsRun two = cells_run({.brokers = 2}, 300, 900);
    EXPECT_NEAR(two.delivered_per_s, 300, 5);
    EXPECT_GE(two.delivered, 896U);
}

TEST(ManyCells, OnOneChannelTheyShareWhatItCarries) {
    const CellsRun two = cells_run({.brokers = 2, .channels = 1}, 500, 1'500);
    EXPECT_LT(two.delivered_per_s, 320);
}

TEST(Moves, ABrokersDeathIsASilenceAndNoLossOfWhatWasAcknowledged) {
    const MovesRun calm = moves_run(Change::none, 1);
    EXPECT_EQ(calm.lost_qos0, 0U);
    EXPECT_EQ(calm.lost_qos1, 0U);
    EXPECT_EQ(calm.joins, 0U);
    const MovesRun dead = moves_run(Change::broker_dies, 1);
    EXPECT_EQ(dead.lost_qos1, 0U);
    EXPECT_EQ(dead.reconnects, 0U);
    for (const double ms : dead.silence_ms) {
        EXPECT_GT(ms, 300);  // beacons missing for 500 ms
        EXPECT_LT(ms, 3'000);
    }
}

TEST(Moves, WhoDrivesIntoAnotherCellTalksToItsBrokerAndLosesNothingAcknowledged) {
    const MovesRun driven = moves_run(Change::robots_leave, 1);
    EXPECT_GT(driven.joins, 0U);
    EXPECT_EQ(driven.reconnects, 0U);
    EXPECT_EQ(driven.lost_qos1, 0U);
    EXPECT_LE(driven.lost_qos0, 2 * driven.joins);
}

TEST(Backbone, BeaconsOfManyBrokersTakeTheChannelFromTheRobots) {
    using std::chrono_literals::operator""ms;
    const BackboneRun few = backbone_run(2, {"mesh", 1'000ms}, 1);
    EXPECT_GT(few.beacon_octets, 88);
    EXPECT_GE(few.delivered_at_100, 0.99);
    const BackboneRun many = backbone_run(8, {"wifi", 50ms}, 1);
    EXPECT_GT(many.beacon_octets, few.beacon_octets);
    EXPECT_GT(many.beacons_air, 10 * few.beacons_air);
    EXPECT_LT(many.carried_per_s, 0.7 * few.carried_per_s);
}

}  // namespace
}  // namespace romano::experiments::paper_test
