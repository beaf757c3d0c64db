#include "experiments/web/web_api.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "experiments/web/page_files.h"

namespace romano::experiments::web_api_test {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
using ::testing::Not;

struct Api : ::testing::Test, Steering {
    Api() {
        server::NodeEntry entry;
        entry.id = *message::RomanoId::parse("abcd1234");
        entry.home = "r1<script>\xff";
        picture.on_link(Instant{1s}, true);
        picture.on_entry(Instant{1s}, entry);
    }
    std::uint64_t carry_out(const Orders& orders) override {
        sent.push_back(orders);
        return sent.size();
    }
    WebAnswer get(const std::string& target) {
        return api.answer({.method = "GET", .target = target, .fields = own, .body = {}});
    }
    WebAnswer post(const std::string& target, const std::string& body = "{}") {
        return api.answer({.method = "POST", .target = target, .fields = own, .body = body});
    }

    const RequestFields own{.host = "127.0.0.1:8080",
                            .origin = "http://127.0.0.1:8080",
                            .fetch_site = "same-origin",
                            .content_type = "application/json"};
    std::vector<Orders> sent;
    FleetPicture picture{Duration{0}};
    WebApi api{picture, *this, std::vector<std::string>{"localhost", "r1"}};
};

TEST_F(Api, TellsTheFleetAndOneRobot) {
    const WebAnswer state = get("/api/state?again=1");
    EXPECT_EQ(state.status, 200U);
    EXPECT_EQ(state.content_type, "application/json");
    const auto fleet = nlohmann::json::parse(state.body);
    EXPECT_EQ(fleet.at("robots").at(0).at("robot"), "abcd1234");
    EXPECT_EQ(fleet.at("robots").at(0).at("home"), "r1<script>\uFFFD");
    const WebAnswer robot = get("/api/robots/abcd1234");
    EXPECT_TRUE(nlohmann::json::parse(robot.body).at("messages").is_array());
    EXPECT_EQ(get("/api/robots/00000009").status, 404U);
    EXPECT_EQ(get("/api/robots/%3Cscript%3E").status, 404U);
    EXPECT_TRUE(get("/api/events").is_event_stream);
}

TEST_F(Api, ServesThePageAndNothingElse) {
    EXPECT_THAT(get("/").body, HasSubstr("<title>ROMANO fleet</title>"));
    EXPECT_EQ(get("/style.css").content_type, "text/css; charset=utf-8");
    EXPECT_EQ(get("/fleet.js").content_type, "text/javascript; charset=utf-8");
    for (const char* path : {"/../README.md", "/etc/passwd", "//", "/index.html/", "/api"}) {
        EXPECT_EQ(get(path).status, 404U) << path;
    }
}

// It works without the internet, and tells nobody elsewhere that it is looked at.
TEST_F(Api, ThePageNeedsNothingFromElsewhere) {
    for (const PageFile& file : page_files()) {
        std::string text{file.content};
        for (const std::string_view fine : {"http://www.w3.org/2000/svg"}) {
            for (auto at = text.find(fine); at != text.npos; at = text.find(fine)) {
                text.erase(at, fine.size());
            }
        }
        EXPECT_THAT(text, Not(HasSubstr("://"))) << file.path;
        EXPECT_THAT(text, Not(HasSubstr("innerHTML"))) << file.path;
    }
}

TEST_F(Api, MovesAndStopsRobots) {
    const WebAnswer moved =
        post("/api/robots/abcd1234/move", R"({"movement": "front", "amount": "100mm"})");
    EXPECT_EQ(moved.status, 202U);
    EXPECT_EQ(nlohmann::json::parse(moved.body).at("command"), 1);
    EXPECT_EQ(post("/api/robots/abcd1234/stop").status, 202U);
    EXPECT_EQ(post("/api/stop").status, 202U);
    ASSERT_EQ(sent.size(), 3U);
    EXPECT_EQ(sent[0].words, "move front 100mm");
    EXPECT_EQ(sent[1].orders.size(), 1U);
    EXPECT_EQ(sent[2].orders[0].topic, "common");
}

TEST_F(Api, SaysInOneSentenceWhatIsWrongWithAnOrder) {
    const auto error = [](const WebAnswer& answer) {
        return nlohmann::json::parse(answer.body).at("error").get<std::string>();
    };
    WebAnswer refused = post("/api/robots/abcd1234/move", "front");
    EXPECT_EQ(refused.status, 400U);
    EXPECT_THAT(error(refused), HasSubstr("must be a JSON object"));
    refused = post("/api/robots/abcd1234/move", R"({"movement": "front", "amount": 100})");
    EXPECT_THAT(error(refused), HasSubstr("amount: must be a text"));
    refused = post("/api/robots/abcd1234/move", R"({"movement": "up", "amount": "1mm"})");
    EXPECT_THAT(error(refused), HasSubstr("`up`: must be front"));
    EXPECT_EQ(post("/api/robots/00000009/stop").status, 404U);
    EXPECT_EQ(post("/api/robots/abcd1234/dance").status, 404U);
    EXPECT_EQ(get("/api/stop").status, 405U);
    EXPECT_EQ(get("/api/stop").allow, "POST");
    EXPECT_EQ(post("/api/state").status, 405U);
    picture.on_link(Instant{2s}, false);
    EXPECT_EQ(post("/api/stop").status, 503U);
    EXPECT_TRUE(sent.empty());
}

struct Foreign : Api, ::testing::WithParamInterface<RequestFields> {};

TEST_P(Foreign, PageSteersNoRobot) {
    const WebAnswer answer =
        api.answer({.method = "POST", .target = "/api/stop", .fields = GetParam(), .body = "{}"});
    EXPECT_THAT(answer.status, ::testing::AnyOf(403U, 421U));
    EXPECT_TRUE(sent.empty());
}

INSTANTIATE_TEST_SUITE_P(
    Requests, Foreign,
    ::testing::Values(
        RequestFields{"127.0.0.1:8080", "http://evil.example", "", "application/json"},
        RequestFields{"127.0.0.1:8080", "http://127.0.0.1:9090", "", "application/json"},
        RequestFields{"127.0.0.1:8080", "null", "", "application/json"},
        RequestFields{"127.0.0.1:8080", "", "cross-site", "application/json"},
        RequestFields{"127.0.0.1:8080", "", "same-site", "application/json"},
        // What a form or an image of another page can send without asking.
        RequestFields{"127.0.0.1:8080", "", "", ""},
        RequestFields{"127.0.0.1:8080", "", "", "text/plain"},
        RequestFields{"127.0.0.1:8080", "", "", "application/x-www-form-urlencoded"},
        // A name of another page, which resolves to this machine.
        RequestFields{"evil.example:8080", "http://evil.example:8080", "same-origin",
                      "application/json"},
        RequestFields{"127.0.0.1.evil.example", "", "", "application/json"},
        RequestFields{"", "", "", "application/json"}));

TEST(RequestRules, AProgramOnThisMachineNeedsItsAddressAndTheContentType) {
    EXPECT_FALSE(objection_to_change({.host = "localhost:8080",
                                      .origin = "",
                                      .fetch_site = "",
                                      .content_type = "application/json; charset=utf-8"}));
    for (const char* host : {"127.0.0.1", "127.0.0.1:8080", "[::1]:8080", "[::1]", "10.0.0.7:80",
                             "localhost:1", "LocalHost", "r1:8080"}) {
        EXPECT_TRUE(is_own_host(host, {"localhost", "r1"})) << host;
    }
    for (const char* host : {"", ":8080", "r2", "[", "[]", "r1.evil.example", "::1:8080"}) {
        EXPECT_FALSE(is_own_host(host, {"localhost", "r1"})) << host;
    }
}

TEST_F(Api, AFleetThatIsThereIsNoRecording) {
    EXPECT_EQ(post("/api/recording", R"({"play": true})").status, 404U);
    EXPECT_EQ(get("/api/recording").status, 405U);
}

struct NoFile final : mcap::OctetSource {
    [[nodiscard]] Bytes read(std::uint64_t, std::size_t) override { return {}; }
    [[nodiscard]] std::uint64_t size() const override { return 0; }
};

TEST_F(Api, ARecordingIsPlayedAndNobodyIsSteered) {
    NoFile file;
    mcap::Reader reader{file};
    FleetPicture played{Duration{0}};
    Playback playback{reader, "<b>.mcap", played};
    WebApi recording{played, playback, std::vector<std::string>{}};
    const auto ask = [&](const std::string& target, const std::string& body) {
        return recording.answer({.method = "POST", .target = target, .fields = own, .body = body});
    };
    EXPECT_EQ(ask("/api/recording", R"({"play": false, "speed": 0.5})").status, 202U);
    playback.on_tick(Instant{1s});
    EXPECT_EQ(played.recording()->speed, 0.5);
    EXPECT_FALSE(played.recording()->is_playing);
    for (const char* wrong :
         {"", "{}", "[]", R"({"speed": 0.01})", R"({"speed": 101})", R"({"speed": "1"})",
          R"({"play": 1})", R"({"at_unix_ms": -1})", R"({"at_unix_ms": 1.5})", R"({"jump": 1})"}) {
        EXPECT_EQ(ask("/api/recording", wrong).status, 400U) << wrong;
    }
    const WebAnswer stop = ask("/api/stop", "{}");
    EXPECT_EQ(stop.status, 409U);
    EXPECT_THAT(stop.body, HasSubstr("nothing was said to any robot"));
}

}  // namespace
}  // namespace romano::experiments::web_api_test
