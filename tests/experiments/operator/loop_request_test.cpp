// What an operator says of a loop, and what a plant reports in words.
#include "experiments/operator/loop_request.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <stdexcept>

namespace romano::experiments::loop_request_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(LoopRequest, NamesLawsWithTheirParameters) {
    const LawRequest follow = law_request("follow", "", 258, "0,0");
    EXPECT_EQ(follow.law, control::Law{1});
    EXPECT_THAT(follow.parameters, ElementsAre(0, 0, 1, 2));
    const LawRequest go_to = law_request("go-to", "", 0, "258,-1");
    EXPECT_EQ(go_to.law, control::Law{2});
    EXPECT_THAT(go_to.parameters, ElementsAre(0, 0, 1, 2, 0xFF, 0xFF, 0xFF, 0xFF));
    const LawRequest own = law_request("700", "0a0B", 0, "");
    EXPECT_EQ(own.law, control::Law{700});
    EXPECT_THAT(own.parameters, ElementsAre(10, 11));
}

TEST(LoopRequest, RefusesWhatItCannotMeanInOneSentence) {
    const auto sentence = [](const auto& request) -> std::string {
        try {
            request();
        } catch (const std::invalid_argument& refused) {
            return refused.what();
        }
        return "";
    };
    EXPECT_THAT(sentence([] { (void)law_request("chase", "", 0, ""); }),
                HasSubstr("--law `chase`: must be follow, go-to, or a number"));
    EXPECT_THAT(sentence([] { (void)law_request("7", "0a0", 0, ""); }),
                HasSubstr("--parameters `0a0`: must be up to 32 octets"));
    EXPECT_THAT(sentence([] { (void)law_request("7", std::string(66, '0'), 0, ""); }),
                HasSubstr("up to 32 octets"));
    EXPECT_THAT(sentence([] { (void)law_request("go-to", "", 0, "12"); }),
                HasSubstr("--to `12`: must be a point in mm"));
    EXPECT_THAT(sentence([] { (void)fallback_named("run"); }), HasSubstr("stop, hold or own-law"));
    EXPECT_THAT(sentence([] { (void)robot_id("plant", "ABCD1234"); }),
                HasSubstr("plant `ABCD1234`: must be the id of a robot"));
}

TEST(LoopRequest, ReportsAreOneLineOrOneObject) {
    const control::Report report{.channel = control::Channel{0},
                                 .session = control::Session{77},
                                 .plant = *message::RomanoId::parse("00000002"),
                                 .controller = *message::RomanoId::parse("00000001"),
                                 .state = control::State::controlled,
                                 .reason = control::Reason::none,
                                 .counters = {.samples = 10, .accepted = 9, .falls = 1},
                                 .ages = {1000, 500, 1250, 2000, 100}};
    EXPECT_EQ(to_line(report),
              "controlled by 00000001: 10 samples, 9 commands carried out, 0 late, 0 repeated, "
              "0 foreign; fell back 1 times; age 1.2 ms (0.5 to 2.0, jitter 0.1)");
    const auto object = to_json(report);
    EXPECT_EQ(object["state"], "controlled");
    EXPECT_EQ(object["age_us"]["greatest"], 2000);
    EXPECT_EQ(object["session"], 77);
}

}  // namespace
}  // namespace romano::experiments::loop_request_test
