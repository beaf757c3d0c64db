// Robots of the simulated world behind a border router: the shipped cores, on the air.
#include "overlay/radio/radio_network.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "overlay/sim/lone_world.h"

namespace romano::radio::radio_network_test {
namespace {

using namespace std::chrono_literals;
using mqttsn::Qos;

constexpr std::size_t operators = 1;  // the world's first robot: on the broker's wire

/// An operator on the wire publishes; robots two metres from the router hear "common".
class Cell {
public:
    explicit Cell(std::size_t robots, std::optional<std::uint32_t> router_baud = 115'200,
                  std::uint64_t seed = 1)
        : world_(seed) {
        sim::RobotOptions on_the_wire;
        on_the_wire.name = "operator";
        world_.add_robot(on_the_wire);
        RadioOptions options;
        options.router_baud = router_baud;
        options.cells.resize(1);
        for (std::size_t i = 0; i < robots; ++i) {
            sim::RobotOptions robot;
            robot.name = "robot" + std::to_string(i);
            robot.subscriptions = {{"common", Qos::at_most_once}};
            const sim::Robot& added = world_.add_robot(robot);
            options.cells[0].robots.push_back({added.options().address, {2, 0}});
        }
        network_.emplace(world_, options);
        for (std::size_t i = 0; i < world_.robot_count(); ++i) world_.robot(i).start();
    }

    bool is_ready() {
        return world_.run_until(
            [this] {
                return world_.robots_are_idle() &&
                       world_.ledger().subscriptions.size() + operators == world_.robot_count();
            },
            20s);
    }
    void publish(std::size_t count, Duration every) {
        for (std::size_t i = 0; i < count; ++i) {
            (void)world_.robot(0).publish("common", Qos::at_most_once);
            world_.run_for(every);
        }
        world_.run_for(10s);
    }
    [[nodiscard]] double mean_delay_ms(const std::string& robot) {
        Duration sum{};
        std::int64_t count = 0;
        for (const auto& reception : world_.ledger().receptions) {
            if (reception.subscriber != robot) continue;
            sum += reception.at - world_.ledger().sent.at({"operator", reception.number}).at;
            ++count;
        }
        return std::chrono::duration<double, std::milli>(sum / std::max<std::int64_t>(count, 1))
            .count();
    }
    sim::LoneWorld& world() { return world_; }
    RadioNetwork& network() { return *network_; }

private:
    sim::LoneWorld world_;
    std::optional<RadioNetwork> network_;
};

TEST(RadioNetwork, OneHopTakes17Point8MsAt115200BaudAnd13Point2At230400) {
    for (const auto& [baud, expected_ms] : {std::pair{115'200U, 17.8}, {230'400U, 13.2}}) {
        Cell cell(1, baud);
        ASSERT_TRUE(cell.is_ready());
        cell.publish(200, 50ms);
        EXPECT_NEAR(cell.mean_delay_ms("robot0"), expected_ms, 0.05 * expected_ms) << baud;
    }
}

TEST(RadioNetwork, EachFurtherSubscriberWaitsForTheLineOrForTheRadio) {
    for (const auto& [baud, expected_ms] : {std::pair{115'200U, 9.1}, {230'400U, 4.8}}) {
        Cell cell(5, baud);
        ASSERT_TRUE(cell.is_ready());
        cell.publish(100, 100ms);
        std::vector<double> delays;  // the broker's order is its own
        for (int i = 0; i < 5; ++i) {
            delays.push_back(cell.mean_delay_ms("robot" + std::to_string(i)));
        }
        const auto [least, most] = std::ranges::minmax(delays);
        const double more = (most - least) / 4;
        EXPECT_NEAR(more, expected_ms, 0.05 * expected_ms) << baud;
    }
}

TEST(RadioNetwork, AQueueThatIsFullLosesAndCounts) {
    Cell cell(1);
    ASSERT_TRUE(cell.is_ready());
    EXPECT_FALSE(cell.network().first_overflow());
    cell.publish(2'000, 2ms);
    ASSERT_TRUE(cell.network().first_overflow());
    const auto& receptions = cell.world().ledger().receptions;
    EXPECT_EQ(receptions.size() + cell.network().lost(), 2'000U);
    EXPECT_NEAR(static_cast<double>(receptions.size()), 500 + 4'000 / 9.115, 40);
}

TEST(RadioNetwork, RobotsThatLeaveTheCellHearNothingUntilTheyAreBack) {
    Cell cell(2, std::nullopt);
    ASSERT_TRUE(cell.is_ready());
    const Endpoint leaves = cell.world().robot(operators).options().address;
    cell.network().move(leaves, {2'000, 0});
    cell.publish(10, 100ms);
    EXPECT_EQ(cell.world().ledger().receptions.size(), 10U);  // of the other one
    cell.network().move(leaves, {2, 0});
    cell.publish(10, 100ms);
    EXPECT_EQ(cell.world().ledger().receptions.size(), 30U);
}

TEST(RadioNetwork, ARobotHearsTheCellThatItHasJoinedAndIsCalledInVainInTheOneThatItLeft) {
    sim::LoneWorld world(1);
    sim::RobotOptions robot;
    robot.name = "robot";
    robot.subscriptions = {{"common", Qos::at_most_once}};
    const Endpoint its = world.add_robot(robot).options().address;
    RadioOptions options;
    options.router_baud.reset();
    options.robot_baud.reset();
    options.cells = {{.channel = 11, .router = {0, 0}, .robots = {{its, {2, 0}}}},
                     {.channel = 26, .router = {4, 0}, .robots = {{its, {2, 0}}}}};
    RadioNetwork network(world, options);
    world.robot(0).start();
    ASSERT_TRUE(world.run_until([&] { return world.ledger().subscriptions.size() == 1; }, 20s));
    const auto comes = [&] {
        const std::size_t before = world.ledger().receptions.size();
        (void)world.robot(0).publish("common", Qos::at_most_once);
        world.run_for(1s);
        return world.ledger().receptions.size() > before;
    };
    const auto frames = [&](std::size_t cell) { return network.sent_by_router(cell).frames; };
    EXPECT_TRUE(comes());
    EXPECT_EQ(frames(1), 0U);
    network.join(its, 1);
    const std::uint64_t before = frames(0);
    EXPECT_TRUE(comes());
    EXPECT_GT(frames(1), 0U);
    EXPECT_EQ(frames(0), before);
    network.switch_off_router(1);
    EXPECT_LT(network.hears_dbm(its, 1), -100);
    EXPECT_GT(network.hears_dbm(its, 0), -80);
    EXPECT_FALSE(comes());
    network.join(its, 0);
    EXPECT_TRUE(comes());
}

TEST(RadioNetwork, OneSeedIsOneRun) {
    const auto hash_of = [](std::uint64_t seed) {
        Cell cell(5, 230'400, seed);
        EXPECT_TRUE(cell.is_ready());
        cell.publish(100, 10ms);
        return cell.world().trace().hash();
    };
    const std::uint64_t first = hash_of(7);
    EXPECT_EQ(first, hash_of(7));
    EXPECT_NE(first, hash_of(8));
}

TEST(RadioOptions, ImpossibleChannelsAndBaudRatesGetOneSentence) {
    RadioOptions options;
    options.cells.resize(1);
    EXPECT_FALSE(problem_with(options));
    options.cells[0].channel = 27;
    EXPECT_EQ(problem_with(options),
              "channel 27 does not exist: IEEE 802.15.4 at 2.4 GHz has channels 11 to 26");
    options.cells[0].channel = 11;
    options.robot_baud = 0;
    EXPECT_EQ(problem_with(options),
              "a UART of 0 baud cannot be: give 1200 to 10000000 baud, or none");
}

}  // namespace
}  // namespace romano::radio::radio_network_test
