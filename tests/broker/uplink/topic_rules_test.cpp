// Which topics go over the uplink, and how they are called there.

#include "broker/uplink/topic_rules.h"

#include <gmock/gmock.h>

namespace romano::uplink::topic_rules_test {
namespace {

using mqttsn::Qos;
using testing::ElementsAre;
using testing::HasSubstr;

TopicRules rules(const std::vector<std::string>& texts) {
    std::vector<TopicRule> parsed;
    parsed.reserve(texts.size());
    for (const std::string& text : texts) parsed.push_back(parse_rule(text).value());
    return TopicRules{parsed};
}

TEST(TopicRule, GoesBothWaysAtQos2UnlessSaid) {
    const auto rule = parse_rule("fleet/#").value();
    EXPECT_TRUE(rule.out);
    EXPECT_TRUE(rule.in);
    EXPECT_EQ(rule.most, Qos::exactly_once);
}

TEST(TopicRule, IsRefusedWithWhatIsAllowed) {
    const auto why = [](const char* text) {
        const auto rule = parse_rule(text);
        return rule ? std::string{"accepted"} : rule.error();
    };
    EXPECT_THAT(why(""), HasSubstr("PATTERN"));
    EXPECT_THAT(why("a both 1 b/ c/ d"), HasSubstr("PATTERN"));
    EXPECT_THAT(why("a/#/b"), HasSubstr("filter"));
    EXPECT_THAT(why("$SYS/#"), HasSubstr("$"));
    EXPECT_THAT(why("a up"), HasSubstr("out, in or both"));
    EXPECT_THAT(why("a out 3"), HasSubstr("0, 1 or 2"));
    EXPECT_THAT(why("a out 1 +/"), HasSubstr("without wildcards"));
    EXPECT_THAT(why("a out 1 $x/"), HasSubstr("prefix"));
    EXPECT_THAT(why("# out 1 x"), HasSubstr("end with /"));
}

TEST(TopicRules, ChangePrefixesOnTheWayAndBack) {
    const TopicRules fleet = rules({R"(# both 2 robots/ site-a/)"});
    EXPECT_EQ(fleet.to_remote("robots/1/pose", Qos::at_least_once),
              (Place{"site-a/1/pose", Qos::at_least_once}));
    EXPECT_EQ(fleet.to_local("site-a/1/pose", Qos::at_least_once),
              (Place{"robots/1/pose", Qos::at_least_once}));
    EXPECT_FALSE(fleet.to_remote("site-a/1/pose", Qos::at_least_once));
    EXPECT_THAT(fleet.local_filters(), ElementsAre(Filter{"robots/#", Qos::exactly_once}));
    EXPECT_THAT(fleet.remote_filters(), ElementsAre(Filter{"site-a/#", Qos::exactly_once}));
}

TEST(TopicRules, EmptyPrefixesAreWrittenAsQuotes) {
    const TopicRules poses = rules({R"(pose/# out 0 "" site-a/)"});
    EXPECT_EQ(poses.to_remote("pose/7", Qos::exactly_once),
              (Place{"site-a/pose/7", Qos::at_most_once}));
}

TEST(TopicRules, OneWayRulesGoOneWay) {
    const TopicRules one_way = rules({"a out", "b in"});
    EXPECT_TRUE(one_way.to_remote("a", Qos::at_most_once));
    EXPECT_FALSE(one_way.to_local("a", Qos::at_most_once));
    EXPECT_FALSE(one_way.to_remote("b", Qos::at_most_once));
    EXPECT_TRUE(one_way.to_local("b", Qos::at_most_once));
    EXPECT_THAT(one_way.local_filters(), ElementsAre(Filter{"a", Qos::exactly_once}));
}

TEST(TopicRules, TheBrokersOwnTopicsStayHere) {
    const TopicRules all = rules({"#"});
    EXPECT_FALSE(all.to_remote("$SYS/brokers/r1", Qos::at_most_once));
    EXPECT_FALSE(all.to_local("$SYS/broker/uptime", Qos::at_most_once));
}

TEST(TopicRules, WhatCannotBeATopicHereDoesNotComeIn) {
    const TopicRules all = rules({R"(# in 1 "" x/)"});
    EXPECT_FALSE(all.to_local("x/", Qos::at_most_once));
    EXPECT_FALSE(all.to_local("x/$SYS/brokers/r1", Qos::at_most_once));
}

}  // namespace
}  // namespace romano::uplink::topic_rules_test
