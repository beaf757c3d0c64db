// MQTT 3.1.1 section 4.7: topic names and topic filters.

#include "romano/mqttsn/topic.h"

#include <gtest/gtest.h>

#include <string>
#include <string_view>

namespace romano::mqttsn::topic_test {
namespace {

using namespace std::string_view_literals;

TEST(TopicName, HasAtLeastOneOctet) {  // [MQTT-4.7.3-1]
    EXPECT_FALSE(is_valid_topic_name(""));
    EXPECT_FALSE(is_valid_topic_filter(""));
    EXPECT_TRUE(is_valid_topic_name("/"));
    EXPECT_TRUE(is_valid_topic_name("a//b/"));
    EXPECT_TRUE(is_valid_topic_name(" "));
}

TEST(TopicName, HasNoNullCharacter) {  // [MQTT-4.7.3-2]
    EXPECT_FALSE(is_valid_topic_name("a\0b"sv));
    EXPECT_FALSE(is_valid_topic_filter("a/\0/#"sv));
}

TEST(TopicName, HasNoWildcard) {  // [MQTT-4.7.1-1]
    for (const auto name : {"#", "+", "a/#", "a/+/b", "a+", "#a"}) {
        EXPECT_FALSE(is_valid_topic_name(name)) << name;
    }
}

TEST(TopicName, IsWellFormedUtf8) {  // [MQTT-1.5.3-1]
    for (const auto fine : {"é", "日本", "\xF0\x9F\xA4\x96", "\xED\x9F\xBF", "\xEE\x80\x80",
                            "\xF4\x8F\xBF\xBF", "\xC2\x80", "\xE0\xA0\x80", "\xF0\x90\x80\x80"}) {
        EXPECT_TRUE(is_valid_topic_name(fine)) << fine;
    }
    const std::string_view ill_formed[] = {
        "\x80",              // a continuation alone
        "\xC3",              // cut off
        "\xE2\x82",          // cut off
        "\xF0\x9F\xA4",      // cut off
        "\xC3\x28",          // no continuation
        "\xE2\x28\xA1",      //
        "\xE2\x82\x28",      //
        "\xC0\xAF",          // overlong
        "\xC1\xBF",          //
        "\xE0\x9F\xBF",      //
        "\xF0\x8F\xBF\xBF",  //
        "\xED\xA0\x80",      // surrogates
        "\xED\xBF\xBF",      //
        "\xF4\x90\x80\x80",  // beyond U+10FFFF
        "\xF5\x80\x80\x80",  //
        "\xFF",              //
    };
    for (const auto name : ill_formed) EXPECT_FALSE(is_valid_topic_name(name)) << name;
}

TEST(TopicFilter, MultiLevelWildcardIsAloneInTheLastLevel) {  // [MQTT-4.7.1-2]
    for (const auto filter : {"#", "/#", "a/#", "a/b/#", "+/#"}) {
        EXPECT_TRUE(is_valid_topic_filter(filter)) << filter;
    }
    for (const auto filter : {"a#", "a/b#", "a/#/b", "#/a", "##", "#/", "+#"}) {
        EXPECT_FALSE(is_valid_topic_filter(filter)) << filter;
    }
}

TEST(TopicFilter, SingleLevelWildcardFillsAWholeLevel) {  // [MQTT-4.7.1-3]
    for (const auto filter : {"+", "+/a", "a/+", "a/+/b", "/+", "+/", "+/+/+"}) {
        EXPECT_TRUE(is_valid_topic_filter(filter)) << filter;
    }
    for (const auto filter : {"a+", "+a", "a/b+", "a/+b/c", "++"}) {
        EXPECT_FALSE(is_valid_topic_filter(filter)) << filter;
    }
}

TEST(TopicFilter, WithoutWildcardMatchesOnlyItself) {  // [MQTT-4.7.3-4]
    EXPECT_TRUE(matches("a/b", "a/b"));
    for (const auto name : {"a", "a/", "a/b/", "a/b/c", "A/b", "/a/b", "a/bb", "b"}) {
        EXPECT_FALSE(matches("a/b", name)) << name;
    }
}

TEST(TopicFilter, MultiLevelWildcardMatchesTheParentAndAllBelow) {
    for (const auto name : {"a", "a/", "a/b", "a/b/c"}) EXPECT_TRUE(matches("a/#", name)) << name;
    for (const auto name : {"b", "ab", "/a", "ab/c"}) EXPECT_FALSE(matches("a/#", name)) << name;
    for (const auto name : {"a", "/", "/a", "a/b/c"}) EXPECT_TRUE(matches("#", name)) << name;
    EXPECT_TRUE(matches("/#", "/"));
    EXPECT_TRUE(matches("/#", "/a"));
    EXPECT_FALSE(matches("/#", "a"));
    EXPECT_TRUE(matches("+/#", "a"));
    EXPECT_TRUE(matches("a/+/#", "a/b"));
    EXPECT_FALSE(matches("a/+/#", "a"));
}

TEST(TopicFilter, SingleLevelWildcardMatchesExactlyOneLevel) {
    EXPECT_TRUE(matches("a/+", "a/b"));
    EXPECT_TRUE(matches("a/+", "a/"));
    EXPECT_FALSE(matches("a/+", "a"));
    EXPECT_FALSE(matches("a/+", "a/b/c"));
    EXPECT_TRUE(matches("+", "a"));
    EXPECT_FALSE(matches("+", "/a"));
    EXPECT_TRUE(matches("/+", "/a"));
    EXPECT_TRUE(matches("+/+", "/a"));
    EXPECT_TRUE(matches("a/+/c", "a/b/c"));
    EXPECT_TRUE(matches("a/+/c", "a//c"));
    EXPECT_FALSE(matches("a/+/c", "a/b/d"));
    EXPECT_FALSE(matches("a/+/c", "a/b/c/d"));
}

TEST(TopicFilter, ThatBeginsWithAWildcardDoesNotMatchDollarNames) {  // [MQTT-4.7.2-1]
    EXPECT_FALSE(matches("#", "$SYS/brokers"));
    EXPECT_FALSE(matches("+/brokers", "$SYS/brokers"));
    EXPECT_TRUE(matches("$SYS/#", "$SYS/brokers"));
    EXPECT_TRUE(matches("$SYS/+", "$SYS/brokers"));
    EXPECT_TRUE(matches("a/+", "a/$b"));
}

}  // namespace
}  // namespace romano::mqttsn::topic_test
