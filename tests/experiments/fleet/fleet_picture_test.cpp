#include "experiments/fleet/fleet_picture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <nlohmann/json.hpp>
#include <string>

#include "experiments/fleet/picture_json.h"
#include "experiments/operator/robot_message.h"
#include "romano/message/codec.h"

namespace romano::experiments::fleet_picture_test {
namespace {

using namespace std::chrono_literals;
using message::RomanoId;
using server::NodeState;
using ::testing::ElementsAre;

RomanoId id_of(unsigned number) {
    char digits[9];
    std::snprintf(digits, sizeof digits, "%08x", number);
    return *RomanoId::parse(digits);
}

Octets octets_of(const message::Message& message) {
    std::array<std::uint8_t, message::max_message> room{};
    const std::size_t size = message::encode(message, room);
    return {room.begin(), room.begin() + static_cast<std::ptrdiff_t>(size)};
}

Octets location(std::int32_t x_mm, std::int32_t y_mm) {
    std::array<std::uint8_t, 12> value{};
    for (unsigned i = 0; i < 4; ++i) {
        value[i] = static_cast<std::uint8_t>(static_cast<std::uint32_t>(x_mm) >> (24U - 8U * i));
        value[4 + i] =
            static_cast<std::uint8_t>(static_cast<std::uint32_t>(y_mm) >> (24U - 8U * i));
    }
    return octets_of(message::SensorData{message::SensorType::location, value});
}

/// A picture that is told of a cluster of brokers r1, r2..., each with one address.
struct Fleet : ::testing::Test {
    Fleet() {
        picture.on_link(now, true);
        tell_brokers();
    }

    void tell_broker(int n, bool alive, std::vector<int> serves, int leader) {
        BrokerStatus status;
        status.name = "r" + std::to_string(n);
        status.alive = alive;
        status.leader = n == leader;
        for (const int address : serves) {
            status.addresses.push_back("10.0.0." + std::to_string(address) + ":1883");
        }
        status.view_term = 1;
        picture.on_broker(now, status);
    }
    void tell_brokers() {
        for (int n = 1; n <= 3; ++n) tell_broker(n, true, {n}, 3);
    }
    void tell_robot(unsigned robot, const std::string& home,
                    NodeState state = NodeState::connected) {
        picture.on_entry(now, {.id = id_of(robot),
                               .form = server::Form::binary,
                               .state = state,
                               .heartbeat_unix_ms = 0,
                               .home = home,
                               .client = "c"});
    }
    void hear(unsigned robot) {
        picture.on_message(now, "robots/" + std::string{id_of(robot).text()} + "/pose",
                           location(0, 0));
    }
    void pass(Duration time) {
        now += time;
        picture.on_tick(now);
    }
    void settle() { pass(3s); }
    [[nodiscard]] std::vector<std::string_view> kinds() const {
        std::vector<std::string_view> names;
        for (const Happening& one : picture.time_line().happenings()) {
            names.push_back(name_of(one.kind));
        }
        return names;
    }
    [[nodiscard]] const SeenRobot& robot(unsigned n) const { return picture.robots().at(id_of(n)); }

    Instant now{1h};
    FleetPicture picture{Duration{0}};
};

TEST_F(Fleet, WhatWasThereBeforeTheWatcherIsNoNews) {
    tell_robot(1, "r1");
    settle();
    EXPECT_THAT(kinds(), ElementsAre());
    EXPECT_EQ(picture.leader(), "r3");
    EXPECT_EQ(robot(1).home, "r1");
}

TEST_F(Fleet, ADeathRightAfterTheWatcherCameIsNews) {
    tell_robot(1, "r3");
    tell_broker(3, false, {}, 3);
    tell_broker(2, true, {2, 3}, 2);
    EXPECT_THAT(kinds(), ElementsAre("broker-died", "leader", "take-over"));
}

TEST_F(Fleet, TheHeirOfAnAddressIsTheHomeOfItsRobotsAtOnce) {
    tell_robot(1, "r1");
    tell_robot(2, "r1");
    tell_robot(3, "r2");
    settle();
    tell_broker(1, false, {}, 3);
    EXPECT_EQ(robot(1).home, "r1") << "nobody serves its address yet";
    pass(40ms);
    tell_broker(2, true, {2, 1}, 3);
    EXPECT_EQ(robot(1).home, "r2");
    EXPECT_EQ(robot(3).home, "r2");
    EXPECT_THAT(kinds(), ElementsAre("broker-died", "take-over"));
    const Happening& taken = picture.time_line().happenings().back();
    EXPECT_EQ(taken.from, "r1");
    EXPECT_EQ(taken.to, "r2");
    EXPECT_EQ(taken.robot_count, 2U);
    EXPECT_EQ(taken.took, Duration{40ms});
}

TEST_F(Fleet, AnEntryThatStillNamesTheDeadChangesNothing) {
    tell_robot(1, "r1");
    settle();
    tell_broker(1, false, {}, 3);
    tell_broker(2, true, {2, 1}, 3);
    tell_robot(1, "r1", NodeState::silent);
    EXPECT_EQ(robot(1).home, "r2");
    tell_robot(1, "r2");
    EXPECT_EQ(robot(1).home, "r2");
    EXPECT_THAT(kinds(), ElementsAre("broker-died", "take-over", "robots-silent", "robots-back"));
}

TEST_F(Fleet, AHomeThatIsBackIsHandedItsRobots) {
    tell_robot(1, "r1");
    settle();
    tell_broker(1, false, {}, 3);
    tell_broker(2, true, {2, 1}, 3);
    tell_robot(1, "r2");
    pass(5s);
    tell_broker(2, true, {2}, 3);
    tell_broker(1, true, {1}, 3);
    tell_robot(1, "r1");
    EXPECT_THAT(kinds(), ElementsAre("broker-died", "take-over", "broker-back", "hand-back"));
    EXPECT_EQ(picture.time_line().happenings()[2].took, Duration{5s});
}

TEST_F(Fleet, BetweenLivingBrokersARobotRoams) {
    tell_robot(1, "r1");
    settle();
    tell_robot(1, "r2");
    EXPECT_THAT(kinds(), ElementsAre("roam"));
}

TEST_F(Fleet, AMoveTellsHowLongItsRobotsWereNotHeard) {
    tell_robot(1, "r1");
    settle();
    for (int i = 0; i < 5; ++i, pass(100ms)) hear(1);
    pass(350ms);
    hear(1);  // before the entry says so
    pass(100ms);
    tell_robot(1, "r2");
    EXPECT_EQ(picture.time_line().happenings().back().silence, Duration{450ms});
    pass(600ms);
    hear(1);
    EXPECT_EQ(picture.time_line().happenings().back().silence, Duration{700ms});
}

TEST_F(Fleet, TellsHowLongNobodyLed) {
    settle();
    tell_broker(3, false, {}, 3);
    EXPECT_EQ(picture.leader(), "");
    pass(70ms);
    tell_broker(2, true, {2}, 2);
    EXPECT_THAT(kinds(), ElementsAre("broker-died", "leader"));
    EXPECT_EQ(picture.time_line().happenings().back().to, "r2");
    EXPECT_EQ(picture.time_line().happenings().back().took, Duration{70ms});
}

TEST_F(Fleet, RobotsThatLeftWhileNobodyWatchedAreForgotten) {
    tell_robot(1, "r1");
    tell_robot(2, "r1");
    settle();
    picture.on_link(now, false);
    pass(10s);
    EXPECT_EQ(picture.robots().size(), 2U);
    picture.on_link(now, true);
    tell_robot(2, "r1");
    settle();
    EXPECT_EQ(picture.robots().size(), 1U);
    EXPECT_THAT(kinds(), ElementsAre("watch-lost", "watch-back", "robots-left"));
}

TEST_F(Fleet, AMessageIsThatOfTheRobotInItsTopicOrInItself) {
    tell_robot(0xabcd1234, "r1");
    picture.on_message(now, "robots/abcd1234/pose", location(120, -5));
    picture.on_message(now, "common", octets_of(message::Heartbeat{id_of(0xabcd1234)}));
    picture.on_message(now, "robots/00000009/pose", location(7, 7));
    picture.on_message(now, "pose", location(8, 8));
    const SeenRobot& seen = robot(0xabcd1234);
    EXPECT_EQ(seen.place, (Place{.x_mm = 120, .y_mm = -5, .heading_mdeg = 0}));
    EXPECT_EQ(seen.heartbeat, now);
    EXPECT_EQ(seen.messages.size(), 2U);
}

TEST_F(Fleet, WhatIsSaidToARobotIsNoSignOfIt) {
    tell_robot(0xabcd1234, "r1");
    picture.on_message(now, "abcd1234", location(120, -5));
    EXPECT_EQ(robot(0xabcd1234).heard, std::nullopt);
    EXPECT_EQ(robot(0xabcd1234).place, std::nullopt);
    ASSERT_EQ(robot(0xabcd1234).messages.size(), 1U);
    EXPECT_TRUE(robot(0xabcd1234).messages.front().to_robot);
}

TEST_F(Fleet, TellsWhoTalksToWhom) {
    for (const unsigned n : {1U, 2U}) tell_robot(n, "r1");
    tell_robot(3, "r2");
    settle();
    for (int tenth = 0; tenth < 60; ++tenth) {
        for (const unsigned n : {1U, 2U, 3U}) hear(n);
        picture.on_message(now, id_of(3).text(), as_octets("go"));
        if (tenth % 10 == 0) picture.on_message(now, "weather", as_octets("rain"));
        hear(0x40 + static_cast<unsigned>(tenth));  // robots that are not known yet
        pass(100ms);
    }
    const auto talks = to_json(picture).at("talks");
    EXPECT_EQ(talks, nlohmann::ordered_json::parse(R"([
        {"topic": "robots/{id}/pose", "messages_per_s": 10.0},
        {"topic": "weather", "messages_per_s": 1.0},
        {"topic": "{id}", "to": "r2", "messages_per_s": 10.0},
        {"topic": "robots/{id}/pose", "from": "r1", "messages_per_s": 20.0},
        {"topic": "robots/{id}/pose", "from": "r2", "messages_per_s": 10.0}])"));
    for (int second = 0; second < 40; ++second) pass(1s);
    EXPECT_TRUE(to_json(picture).at("talks").empty()) << "silent for half a minute";
}

TEST_F(Fleet, ALineOfWhoTalksToWhomIsToldWhenItChanges) {
    tell_robot(1, "r1");
    settle();
    hear(1);
    pass(1s);
    const std::uint64_t seen = picture.version();
    EXPECT_EQ(changes_since(picture, seen)->count("talks"), 0U);
    hear(1);
    pass(1s);
    EXPECT_EQ(changes_since(picture, seen)->at("talks").size(), 1U);
}

TEST_F(Fleet, OnlySoManyTopicsAreWords) {
    settle();
    for (int n = 0; n < 1000; ++n) {
        picture.on_message(now, "t/" + std::to_string(n), as_octets("x"));
    }
    picture.on_message(now, std::string(60'000, '/'), as_octets("x"));
    pass(1s);
    EXPECT_EQ(to_json(picture).at("talks").size(), Talks::most);
    EXPECT_EQ(picture.dropped(), 1001 - Talks::most);
}

TEST_F(Fleet, ChangesAreWhatIsOtherThanAtAVersion) {
    tell_robot(1, "r1");
    tell_robot(2, "r1");
    settle();
    const std::uint64_t before = picture.version();
    hear(2);
    picture.on_entry_deleted(now, id_of(1));
    const auto changes = changes_since(picture, before);
    ASSERT_TRUE(changes);
    EXPECT_THAT(changes->at("brokers"), ElementsAre());
    ASSERT_EQ(changes->at("robots").size(), 1U);
    EXPECT_EQ(changes->at("robots")[0].at("robot"), "00000002");
    EXPECT_THAT(changes->at("left"), ElementsAre("00000001"));
    EXPECT_EQ(changes_since(picture, picture.version())->at("robots").size(), 0U);
}

TEST_F(Fleet, WhoIsTooFarBehindNeedsTheWhole) {
    const std::uint64_t before = picture.version();
    for (unsigned n = 0; n <= FleetPicture::most_left; ++n) {
        tell_robot(n, "r1");
        picture.on_entry_deleted(now, id_of(n));
    }
    EXPECT_FALSE(changes_since(picture, before));
    EXPECT_TRUE(changes_since(picture, picture.version()));
}

// Promise P8: nothing grows without limit, whatever the network says.
TEST_F(Fleet, WhatTheNetworkSaysIsKeptInBounds) {
    const std::string long_text(60'000, 'x');
    tell_robot(1, long_text);
    settle();
    for (unsigned n = 0; n < FleetPicture::most_robots + 100; ++n) tell_robot(n, long_text);
    for (int n = 0; n < 200; ++n) {
        BrokerStatus status;
        status.name = std::to_string(n) + long_text;
        status.alive = true;
        status.addresses.assign(1000, std::string(500, 'a'));
        status.view_members.assign(1000, std::string(500, 'm'));
        picture.on_broker(now, status);
        picture.on_message(now, "robots/00000001/" + std::to_string(n) + long_text,
                           as_octets(long_text));
        now += 10s;
        tell_robot(1, n % 2 == 0 ? "r1" : "r2");
    }
    EXPECT_EQ(picture.robots().size(), FleetPicture::most_robots);
    EXPECT_EQ(picture.brokers().size(), FleetPicture::most_brokers);
    EXPECT_GT(picture.dropped(), 100U);
    EXPECT_LE(picture.time_line().happenings().size(), TimeLine::most_happenings);
    EXPECT_EQ(robot(1).messages.size(), SeenRobot::most_messages);
    EXPECT_LT(robot(1).messages.back().topic.size(), 200U);
    EXPECT_LT(to_json(picture).dump().size(), 6'000'000U);
}

TEST_F(Fleet, WhatARobotIsToldIsNotLostBehindWhatItSays) {
    tell_robot(1, "r1");
    picture.on_message(now, "00000001", location(1, 1));
    for (int n = 0; n < 1000; ++n) hear(1);
    ASSERT_EQ(robot(1).messages.size(), 2U);
    EXPECT_TRUE(robot(1).messages[0].to_robot);
    EXPECT_EQ(robot(1).messages[1].times, 1000U);
}

TEST_F(Fleet, CommandsDoNotPushADeathOutOfTheTimeLine) {
    settle();
    tell_broker(1, false, {}, 3);
    for (int n = 0; n < 1000; ++n) picture.on_command(now, "stop", {});
    EXPECT_EQ(kinds().front(), "broker-died");
    EXPECT_EQ(kinds().size(), 1 + TimeLine::most_of_a_frequent_kind);
    const std::uint64_t last = picture.time_line().happenings().back().number;
    picture.on_command_ended(last, true);
    EXPECT_EQ(picture.time_line().happenings().back().confirmed, 1U);
}

TEST_F(Fleet, ACommandIsCountedUntilTheBrokerHasItAll) {
    settle();
    const std::uint64_t command = picture.on_command(now, "stop all", {id_of(1), id_of(2)});
    picture.on_command_ended(command, true);
    picture.on_command_ended(command, false);
    const Happening& told = picture.time_line().happenings().back();
    EXPECT_EQ(told.what, "stop all");
    EXPECT_EQ(told.robot_count, 2U);
    EXPECT_EQ(told.confirmed, 1U);
    EXPECT_EQ(told.refused, 1U);
}

TEST(Pace, ASecondHasTheMedianAndTheWorstDelay) {
    FleetPicture picture{Duration{0}};
    Instant now{1h};
    picture.on_tick(now);
    for (const auto delay : {1ms, 9ms, 2ms}) picture.on_echo(delay);
    picture.on_message(now, "a", {});
    picture.on_tick(now + 999ms);
    EXPECT_TRUE(picture.pace().seconds().empty());
    picture.on_tick(now + 1s);
    ASSERT_EQ(picture.pace().seconds().size(), 1U);
    const PaceSecond& second = picture.pace().seconds().front();
    EXPECT_EQ(second.messages, 1U);
    EXPECT_EQ(second.delay, Duration{2ms});
    EXPECT_EQ(second.worst_delay, Duration{9ms});
    picture.on_tick(now + 1h);
    EXPECT_EQ(picture.pace().seconds().size(), 2U) << "one long second, no flood of empty ones";
}

}  // namespace
}  // namespace romano::experiments::fleet_picture_test
