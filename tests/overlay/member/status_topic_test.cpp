#include "overlay/member/status_topic.h"

#include <gmock/gmock.h>

namespace romano::overlay::status_topic_test {
namespace {

using testing::HasSubstr;

Endpoint ipv6(std::array<std::uint8_t, 16> octets, std::uint32_t scope = 0) {
    return {.address = octets, .scope = scope, .port = 1883, .family = Endpoint::Family::ipv6};
}

TEST(StatusTopic, AddressesReadAsPeopleWriteThem) {
    Endpoint v4{};
    v4.address = {127, 0, 0, 1};
    v4.port = 1883;
    v4.family = Endpoint::Family::ipv4;
    EXPECT_EQ(to_text(v4), "127.0.0.1:1883");
    EXPECT_EQ(to_text(ipv6({0x20, 0x01, 0x0d, 0xb8, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1})),
              "[2001:db8::1]:1883");
    EXPECT_EQ(to_text(ipv6({0xfe, 0x80, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1}, 2)),
              "[fe80::1%2]:1883");
    EXPECT_EQ(to_text(ipv6({})), "[::]:1883");
    EXPECT_EQ(to_text(ipv6({0, 1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 6, 0, 0, 0, 8})),
              "[1:2:3:4:5:6:0:8]:1883");
}

TEST(StatusTopic, IsAJsonObjectWithQuotesAndControlsEscaped) {
    cluster::Beacon beacon{.name = "r\"1\\\n", .log = {{}, 7}};
    beacon.sessions = 3;
    beacon.cannot_take = 2;
    beacon.usage.longest_turn_us = 1500;
    beacon.usage.cpu_percent = 12;
    beacon.claim.rank = {.capability = 3, .condition = 75};
    const cluster::View view{.number = {.term = 2, .leader = {}, .count = 4}, .members = {}};
    const std::vector<std::string> names{"a", "b"};
    const std::string json = to_json({.beacon = beacon,
                                      .alive = true,
                                      .leads = false,
                                      .view = view,
                                      .member_names = names,
                                      .leader_name = "a"});
    EXPECT_THAT(json, HasSubstr(R"("name":"r\"1\\\u000a")"));
    EXPECT_THAT(json, HasSubstr(R"("alive":true,"leader":false)"));
    EXPECT_THAT(json, HasSubstr(R"("sessions":3)"));
    EXPECT_THAT(json, HasSubstr(R"("cannot_take":2)"));
    EXPECT_THAT(json, HasSubstr(R"("view":{"term":2,"leader":"a","count":4,"members":["a","b"]})"));
    EXPECT_THAT(json, HasSubstr(R"("incarnation":7)"));
    EXPECT_THAT(json, HasSubstr(R"("longest_turn_us":1500,"cpu_percent":12)"));
    EXPECT_THAT(json, HasSubstr(R"("rank":3,"condition":75)"));
    EXPECT_THAT(json, testing::Not(HasSubstr("does_not_hear")));
    EXPECT_EQ(json.front(), '{');
    EXPECT_EQ(json.back(), '}');
}

TEST(StatusTopic, SaysWhomABrokerDoesNotHear) {
    const cluster::Beacon beacon{.name = "r2"};
    const cluster::View view;
    const std::vector<std::string> names;
    EXPECT_THAT(to_json({.beacon = beacon,
                         .view = view,
                         .member_names = names,
                         .leader_name = "",
                         .does_not_hear = {"r1", "r\"3"}}),
                HasSubstr(R"("does_not_hear":["r1","r\"3"])"));
}

TEST(StatusTopic, SaysWhichSettingsDisagreeAndWhoHasWhat) {
    const cluster::Beacon beacon{.name = "r2"};
    const cluster::View view;
    const std::vector<std::string> names;
    BrokerStatus status{.beacon = beacon, .view = view, .member_names = names, .leader_name = ""};
    EXPECT_THAT(to_json(status), testing::Not(HasSubstr("disagrees")));
    status.teller_name = "r1";
    status.differences = {{"predefined", "1=robots/pose", "1=robots/stop"}, {"acks", "1", "all"}};
    EXPECT_THAT(
        to_json(status),
        HasSubstr(R"("disagrees":{"predefined":{"r2":"1=robots/stop","r1":"1=robots/pose"},)"
                  R"("acks":{"r2":"all","r1":"1"}})"));
}

}  // namespace
}  // namespace romano::overlay::status_topic_test
