// The text of a rights file: what its lines mean, and what is said of one that is wrong.

#include "broker/rights/rules.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace romano::rights::rules_test {
namespace {

using testing::HasSubstr;

Rules rules_of(std::string_view text) {
    auto rules = parse(text);
    EXPECT_TRUE(rules.has_value()) << (rules ? "" : rules.error().what);
    return rules ? *rules : Rules{};
}

void expect_fault(std::string_view text, unsigned line, const std::string& what) {
    const auto rules = parse(text);
    ASSERT_FALSE(rules.has_value()) << text;
    EXPECT_EQ(rules.error().line, line);
    EXPECT_THAT(rules.error().what, HasSubstr(what));
}

TEST(RightsFile, ReadsAsMosquittosDoes) {
    const Rules rules = rules_of(
        "# a comment\r\n"
        "topic read pose/#\n"
        "pattern write status/%i\n"
        "\n"
        "user anna\n"
        "  topic a topic with blanks\n"
        "topic deny secret/#\n");
    EXPECT_EQ(rules.groups.at("plain"), (RuleList{{Access::read, "pose/#"}}));
    EXPECT_EQ(rules.everybody, (RuleList{{Access::write, "status/%i"}}));
    EXPECT_EQ(rules.users.at("anna"),
              (RuleList{{Access::readwrite, "a topic with blanks"}, {Access::deny, "secret/#"}}));
}

TEST(RightsFile, HasGroupsWithMembers) {
    const Rules rules = rules_of(
        "group leaders\nmember r1 r2\nmember r3\ntopic write +/goal\ngroup robots\n"
        "topic announce common\ntopic loop p1");
    EXPECT_EQ(rules.members.at("leaders"), (std::set<std::string>{"r1", "r2", "r3"}));
    EXPECT_EQ(rules.groups.at("leaders"), (RuleList{{Access::write, "+/goal"}}));
    EXPECT_EQ(rules.groups.at("robots"),
              (RuleList{{Access::announce, "common"}, {Access::loop, "p1"}}));
}

TEST(RightsFile, SaysTheLineAndWhatIsWrongThere) {
    expect_fault("topic #\n\nallow all\n", 3, "'allow' begins no line of a rights file");
    expect_fault("user\n", 1, "the name ''");
    expect_fault("user an na\n", 1, "the name 'an na'");
    expect_fault("topic read\n", 1, "a topic is missing");
    expect_fault("topic read a/#/b\n", 1, "'a/#/b' is no topic filter");
    expect_fault("topic raed a/+b\n", 1, "is no topic filter");
    expect_fault("topic write robots/%i\n", 1, "begins with pattern");
    expect_fault("pattern write x%i\n", 1, "is no topic filter");
    expect_fault("topic write $SYS/a\n", 1, "published by brokers alone");
    expect_fault("group robots\nmember r1\n", 2, "nobody is put into the groups robots");
    expect_fault("group mine\nmember\n", 2, "needs the names");
    expect_fault(std::string("topic a\x00z", 9), 1, "is no topic filter");
    expect_fault(std::string(most_octets + 1, '\n'), 1, "larger than a mebioctet");
}

TEST(RightsFile, WhatItSaysOfAFaultFitsATerminal) {
    const auto rules = parse("\x1b[2J" + std::string(500, 'x') + "\n");
    ASSERT_FALSE(rules.has_value());
    EXPECT_THAT(rules.error().what, HasSubstr("'?[2Jxx"));
    EXPECT_LT(rules.error().what.size(), 200u);
}

TEST(RightsFile, TheUsualRulesAreOne) {
    const Rules rules = rules_of(usual_rules());
    EXPECT_FALSE(rules.groups.at("robots").empty());
    EXPECT_FALSE(rules.groups.at("operators").empty());
    EXPECT_FALSE(rules.groups.at("plain").empty());
    EXPECT_FALSE(rules.groups.at("uplink").empty());
}

TEST(RightsFile, ItsDigestIsOfWhatItSaysAndNotOfHow) {
    const std::string one = digest_of(rules_of("user a\ntopic x\nuser b\ntopic read y\n"));
    EXPECT_EQ(one,
              digest_of(rules_of("# b first\nuser b\n topic read y\nuser a\ntopic readwrite x")));
    EXPECT_NE(one, digest_of(rules_of("user a\ntopic x\nuser b\ntopic y\n")));
    EXPECT_NE(digest_of(rules_of("group g\nmember a\n")),
              digest_of(rules_of("group g\nmember b\n")));
    EXPECT_EQ(one.size(), 16u);
}

}  // namespace
}  // namespace romano::rights::rules_test
