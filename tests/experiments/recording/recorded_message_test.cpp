// What stands in a recording: everybody can read it, and it is exactly what was published.

#include "experiments/recording/recorded_message.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace romano::experiments::recorded_message_test {
namespace {

using nlohmann::json;

mcap::Channel channel(const std::string& topic, const std::string& kind = "name") {
    return {.id = 1,
            .schema_id = 1,
            .topic = topic,
            .message_encoding = "json",
            .metadata = {{"topic_type", kind}}};
}

TEST(RecordedMessage, AnyPayloadComesBackAsItWas) {
    std::string all;
    for (int octet = 0; octet < 256; ++octet) all += static_cast<char>(octet);
    const std::vector<std::string> payloads = {"",
                                               "x=1 y=2",
                                               R"({"x": 1})",
                                               "[1e400]",
                                               "\"}",
                                               std::string("\0\n\x1b", 3),
                                               "\xc3\xa4",
                                               all,
                                               "\xed\xa0\x80",
                                               R"({"json":{"text":1},"qos":7})",
                                               std::string(65'000, '['),
                                               std::string(65'000, '\xff'),
                                               "nan",
                                               "-0.0",
                                               std::string(30'000, '[') + std::string(30'000, ']')};
    for (const std::string& payload : payloads) {
        const std::string text =
            recorded_text("a/b", as_octets(payload), mqttsn::Qos::at_least_once, true);
        ASSERT_TRUE(json::accept(text)) << text.substr(0, 200);
        const auto back = recorded_message(channel("a/b"), as_octets(text));
        ASSERT_TRUE(back) << text.substr(0, 200);
        EXPECT_EQ(back->data, payload);
        EXPECT_EQ(back->qos, mqttsn::Qos::at_least_once);
        EXPECT_TRUE(back->retain);
    }
}

TEST(RecordedMessage, ShowsWhatARomanoMessageAndAJsonTextSay) {
    const std::string movement{"\x07\x08\x00\x00\x00\x00\x00\x64", 8};
    const json moved = json::parse(
        recorded_text("abcd1234", as_octets(movement), mqttsn::Qos::exactly_once, false));
    EXPECT_EQ(moved.at("romano").at("type"), "movement-control") << moved;
    EXPECT_EQ(moved.at("romano").at("mm"), 100);
    const json said = json::parse(
        recorded_text("pose", as_octets(R"({"x": 1.5})"), mqttsn::Qos::at_most_once, false));
    EXPECT_EQ(said.at("json").at("x"), 1.5);
    EXPECT_EQ(said.at("text"), R"({"x": 1.5})");
}

TEST(RecordedMessage, TheSchemaHasOneTypeForEachProperty) {
    const json schema = json::parse(recording_schema().data);
    EXPECT_EQ(schema.at("type"), "object");
    for (const auto& [name, property] : schema.at("properties").items()) {
        EXPECT_TRUE(property.at("type").is_string()) << name;
    }
}

TEST(RecordedMessage, WhatOthersWroteIsNone) {
    for (const std::string text :
         {"", "[]", "{}", R"({"qos":3,"retain":false,"text":""})", R"({"qos":-1,"retain":false})",
          R"({"qos":0,"retain":0,"text":""})", R"({"qos":0,"retain":false})",
          R"({"qos":0,"retain":false,"octets":"0"})", R"({"qos":0,"retain":false,"octets":"zz"})",
          R"({"qos":0,"retain":false,"text":7})"}) {
        EXPECT_FALSE(recorded_message(channel("a"), as_octets(text))) << text;
    }
    const std::string good = recorded_text("a", {}, mqttsn::Qos::at_most_once, false);
    mcap::Channel foreign = channel("a");
    foreign.message_encoding = "cdr";
    EXPECT_FALSE(recorded_message(foreign, as_octets(good)));
    foreign = channel("a");
    foreign.metadata.clear();
    EXPECT_FALSE(recorded_message(foreign, as_octets(good)));
}

TEST(RecordedMessage, HeededIsWhatRobotsAndBrokersActOn) {
    const std::string movement{"\x07\x08\x00\x00\x00\x00\x00\x64", 8};
    const std::string place{"\x06\x10\x00\x02\x00\x00\x00\x01\x00\x00\x00\x02\x00\x00\x00\x03", 16};
    EXPECT_TRUE(is_heeded("team/red", as_octets(movement)));
    EXPECT_TRUE(is_heeded("abcd1234", as_octets("anything")));
    EXPECT_TRUE(is_heeded("common", as_octets("anything")));
    EXPECT_TRUE(is_heeded("init-info", as_octets("anything")));
    EXPECT_FALSE(is_heeded("robots/abcd1234/pose", as_octets(place)));
    EXPECT_FALSE(is_heeded("robots/abcd1234/pose", as_octets("x=1")));
}

}  // namespace
}  // namespace romano::experiments::recorded_message_test
