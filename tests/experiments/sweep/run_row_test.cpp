#include "experiments/sweep/run_row.h"

#include <gtest/gtest.h>

#include <set>

namespace romano::experiments::run_row_test {
namespace {

TEST(RunRow, ReadsBackFromItsCsv) {
    RunRow row;
    row.cell = {.number = 7,
                .brokers = 3,
                .robots = 20,
                .rate_per_s = 2.5,
                .payload_octets = 32,
                .qos = QosMix{{0, 1, 2}},
                .elector = "component",
                .detector = "fixed",
                .acks = "all",
                .clients = "protected",
                .backbone = "wifi",
                .router_baud = "115200",
                .robot_baud = "none",
                .fault = Fault::kill_home,
                .seed = 18446744073709551615U,
                .repetition = 2};
    row.status = "broker \"b1\" died, exit code 1";
    row.delay_p99_ms = 1.0 / 3.0;
    const auto read = run_from_csv(to_csv(row));
    ASSERT_TRUE(read);
    EXPECT_EQ(read->cell, row.cell);
    EXPECT_EQ(read->status, row.status);
    EXPECT_FALSE(read->ok());
    EXPECT_EQ(read->delay_p99_ms, row.delay_p99_ms);
    EXPECT_EQ(read->delay_max_ms, std::nullopt);
}

TEST(RunRow, RefusesRowsOfOtherColumns) {
    CsvRow fields = to_csv(RunRow{});
    fields.pop_back();
    EXPECT_FALSE(run_from_csv(fields));
    fields = to_csv(RunRow{});
    fields[1] = "many";
    EXPECT_FALSE(run_from_csv(fields));
}

TEST(RunRow, NamesThePromisesThatWereBroken) {
    RunRow row;
    EXPECT_EQ(row.broken_promises(), "");
    row.acknowledged_but_lost_qos1 = 2;
    row.duplicates_qos1 = 5;  // allowed
    row.out_of_order_qos2 = 1;
    EXPECT_EQ(row.broken_promises(),
              "2 acknowledged messages of QoS 1 lost, 1 messages of QoS 2 out of order");
}

TEST(RunRow, WithoutAcksNothingIsPromisedForACrash) {
    RunRow row;
    row.acknowledged_but_lost_qos1 = 2;
    row.cell.acks = "0";
    EXPECT_NE(row.broken_promises(), "");
    row.cell.fault = Fault::kill_home;
    EXPECT_EQ(row.broken_promises(), "");
}

TEST(RunRow, HasEachColumnOnce) {
    const CsvRow columns = run_columns();
    EXPECT_EQ(std::set<std::string>(columns.begin(), columns.end()).size(), columns.size());
    EXPECT_EQ(to_csv(RunRow{}).size(), columns.size());
}

}  // namespace
}  // namespace romano::experiments::run_row_test
