// `romano cell` as people call it: real brokers and robots with the modelled channel between them.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <utility>

#include "tests/experiments/system/processes.h"

namespace romano::experiments::radio_bridge_test {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

class RadioBridge : public ::testing::Test {
protected:
    [[nodiscard]] std::string said() const {
        std::ifstream trace(trace_);
        return {std::istreambuf_iterator<char>(trace), {}};
    }
    void start_cell(const std::vector<std::string>& more) {
        std::vector<std::string> arguments{"cell", "--listen", air_ + ":" + own_port(), "--broker",
                                           wire_ + ":" + own_port()};
        arguments.insert(arguments.end(), more.begin(), more.end());
        cell_ = std::make_unique<BrokerProcess>("cell", ROMANO_PROGRAM, arguments, trace_);
        for (int i = 0; i < 2000 && said().find("a cell is at") == std::string::npos; ++i) {
            std::this_thread::sleep_for(5ms);
        }
    }

    explicit RadioBridge(const std::vector<std::string>& broker_options = {})
        : broker_(wire_, broker_options) {}

    const std::string wire_ = "127.40.250.11";
    const std::string air_ = "127.40.250.12";
    ServingBroker broker_;
    tests::TemporaryFolder folder_;
    std::filesystem::path trace_ = folder_ / "trace";
    std::unique_ptr<BrokerProcess> cell_;
};

TEST_F(RadioBridge, WhatGoesToARobotTakesTheTimeOfTheLinesAndTheAir) {
    start_cell({"--json", "--most-lag-ms", "1000"});
    const Ran load = run_romano("load -h " + wire_ + " --also " + air_ + " -p " + own_port() +
                                " -q 1 --rate 20 --warm-up 0.2 --duration 1 --json");
    ASSERT_EQ(load.exit_code, 0) << load.output;
    const auto figures = nlohmann::json::parse(load.output);
    EXPECT_GT(figures.at("delivered"), 0);
    EXPECT_EQ(figures.at("lost"), 0);
    // 115200 baud twice and a hop of 3.6 ms: 17 ms without anything that waits.
    EXPECT_GE(figures.at("latency").at("p50_us"), 15'000);
    cell_->stop(5s);
    const std::string told = said();
    const auto cell = nlohmann::json::parse(told.substr(told.find('{')));
    EXPECT_GE(cell.at("datagrams_to_robots"), figures.at("delivered"));
    EXPECT_GT(cell.at("datagrams_to_brokers"), 0);
    EXPECT_GT(cell.at("busiest_cell_air_share"), 0);
}

TEST_F(RadioBridge, WhoFindsNoPlaceIsCounted) {
    start_cell({"--json", "--most-lag-ms", "1000", "--robots", "1"});
    const std::string to_cell = " -h " + air_ + " -p " + own_port() + " --broker-timeout 2";
    EXPECT_EQ(run_romano("pub -t a -m b -q 1" + to_cell).exit_code, 0);
    EXPECT_EQ(run_romano("pub -t a -m b -q 1" + to_cell).exit_code, 2) << "the place is taken";
    cell_->stop(5s);
    const std::string told = said();
    EXPECT_GT(nlohmann::json::parse(told.substr(told.find('{'))).at("without_place"), 0);
}

class RadioBridgeWithAGroup : public RadioBridge {
protected:
    explicit RadioBridgeWithAGroup() : RadioBridge({"--cell-group", group()}) {}
    static std::string group() { return "239.18.83.2:" + own_port(); }
};

TEST_F(RadioBridgeWithAGroup, OneDatagramForManyIsOnceOnTheAir) {
    start_cell({"--json", "--most-lag-ms", "1000", "--cell-group", group()});
    const std::string common =
        " -p " + own_port() + " -q 0 --rate 5 --warm-up 0.2 --duration 1 --json";
    // The publisher is on the wire, of the subscribers, who all listen, two are there and three on
    // the air.
    const Ran load = run_romano("load -h " + wire_ + " --also " + air_ + " --subscribers 5" +
                                common + " --cell-group " + group());
    ASSERT_EQ(load.exit_code, 0) << load.output;
    const auto figures = nlohmann::json::parse(load.output);
    EXPECT_GT(figures.at("delivered"), 0);
    EXPECT_EQ(figures.at("lost"), 0);
    cell_->stop(5s);
    const std::string told = said();
    const auto cell = nlohmann::json::parse(told.substr(told.find('{')));
    EXPECT_GT(cell.at("datagrams_to_cells"), 0);
    const int to_robots = cell.at("datagrams_to_robots");
    EXPECT_GE(5 * to_robots, 2 * figures.at("delivered").get<int>());
}

class RefusedCells : public ::testing::TestWithParam<std::pair<const char*, const char*>> {};

TEST_P(RefusedCells, SayOneSentenceAndExitWith2) {
    const auto [arguments, sentence] = GetParam();
    const Ran ran = run_romano(std::string{"cell "} + arguments);
    EXPECT_EQ(ran.exit_code, 2);
    EXPECT_THAT(ran.output, HasSubstr(sentence));
    EXPECT_EQ(std::count(ran.output.begin(), ran.output.end(), '\n'), 1) << ran.output;
}

INSTANTIATE_TEST_SUITE_P(
    Cell, RefusedCells,
    ::testing::Values(
        std::pair{"--broker 127.0.0.1:1", "--listen is required"},
        std::pair{"--listen 127.0.1.1:1883 --listen 127.0.1.2:1883 --broker 127.0.0.1:1",
                  "--listen is given 2 times and --broker 1 times: each cell has one of both"},
        std::pair{"--listen here:1 --broker 127.0.0.1:1",
                  "--listen `here:1`: must be an IP address and a port"},
        std::pair{"--listen 192.0.2.1:1 --broker 127.0.0.1:1", "--listen or --broker: Cannot"},
        std::pair{"--listen 127.0.1.1:1883 --broker 127.0.0.1:1 --router-baud 0",
                  "a UART of 0 baud cannot be: give 1200 to 10000000 baud, or none"},
        std::pair{"--listen 127.0.1.1:1883 --broker 127.0.0.1:1 --robot-baud slow",
                  "--robot-baud `slow`: must be a baud, or none"},
        std::pair{"--listen 127.0.1.1:1883 --broker 127.0.0.1:1 --channels 17",
                  "--channels: Value 17 not in range 1 to 16"},
        std::pair{"--listen 127.0.1.1:1883 --broker 127.0.0.1:1 --cell-group 127.0.0.1:1884",
                  "--cell-group is no multicast group and port"},
        std::pair{"--listen 127.0.1.1:1883 --broker 127.0.0.1:1 --most-lag-ms nan",
                  "--most-lag-ms: Value nan not in range 0.1 to 1000"}));

}  // namespace
}  // namespace romano::experiments::radio_bridge_test
