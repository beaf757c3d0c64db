// A recording on the fleet's page: it plays at its pace, from any place, and shows what was known
// there.

#include "experiments/recording/playback.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "experiments/fleet/picture_json.h"
#include "experiments/recording/recorded_message.h"
#include "tests/experiments/mcap/files_in_memory.h"

namespace romano::experiments::playback_test {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr mcap::Timestamp ms = 1'000'000;
constexpr std::uint64_t start_ms = 1'764'000'000'000;

struct Film {
    Film() : writer(recording_schema(), "json") { file.append(writer.beginning("test")); }

    void link(std::uint64_t at_ms, bool is_linked) {
        const std::string text = recorded_link(is_linked, "there");
        (void)writer.add((start_ms + at_ms) * ms, recorder_topic, recorder_kind, as_octets(text));
    }
    void say(std::uint64_t at_ms, const std::string& topic, const std::string& data) {
        const std::string text =
            recorded_text(topic, as_octets(data), mqttsn::Qos::at_most_once, false);
        (void)writer.add((start_ms + at_ms) * ms, topic, "name", as_octets(text));
        if (writer.waiting() > 10'000) file.append(writer.take_chunk());
    }
    void broker(std::uint64_t at_ms, const std::string& name, bool alive) {
        say(at_ms, "$SYS/brokers/" + name,
            nlohmann::json{{"name", name}, {"alive", alive}, {"leader", alive}}.dump());
    }
    void robot(std::uint64_t at_ms, const std::string& id, const std::string& home) {
        server::NodeEntry entry;
        entry.id = *message::RomanoId::parse(id);
        entry.home = home;
        say(at_ms, "$ROMANO/nodes/" + id, server::to_text(entry));
    }
    void end() {
        file.append(writer.take_chunk());
        file.finish();
    }

    mcap::FileInMemory file;
    mcap::ChunkWriter writer;
};

/// Twenty seconds: a robot is at r1, which dies after ten; then it is at r2. It says something each
/// 100 ms.
Film a_death() {
    Film film;
    film.link(0, true);
    film.broker(1, "r1", true);
    film.broker(2, "r2", true);
    film.robot(3, "abcd1234", "r1");
    for (std::uint64_t at = 100; at <= 20'000; at += 100) {
        if (at == 10'000) film.broker(at, "r1", false);
        if (at == 10'100) film.robot(at, "abcd1234", "r2");
        film.say(at, "robots/abcd1234/pose", std::to_string(at));
    }
    film.end();
    return film;
}

struct Played : testing::Test {
    Played() { playback.on_tick(now); }

    void pass(std::chrono::milliseconds time) {
        for (; time > 0ms; time -= 20ms) playback.on_tick(now += 20ms);
    }
    /// Until somebody's choice is reached.
    void settle() {
        for (int i = 0; i < 10'000 && picture.recording()->is_seeking; ++i) pass(20ms);
        ASSERT_FALSE(picture.recording()->is_seeking);
    }
    [[nodiscard]] std::uint64_t at_ms() const { return picture.recording()->at_unix_ms - start_ms; }
    [[nodiscard]] std::string home() const {
        const auto robot = picture.robots().find(*message::RomanoId::parse("abcd1234"));
        return robot == picture.robots().end() ? "nowhere" : robot->second.home;
    }
    [[nodiscard]] std::string said() const {
        const auto robot = picture.robots().find(*message::RomanoId::parse("abcd1234"));
        return robot->second.messages.empty() ? "" : robot->second.messages.back().text;
    }
    [[nodiscard]] bool has_happened(HappeningKind kind) const {
        return std::ranges::any_of(picture.time_line().happenings(),
                                   [kind](const Happening& one) { return one.kind == kind; });
    }

    Film film = a_death();
    Instant now{1h};
    mcap::Reader reader{film.file};
    FleetPicture picture{Duration{0}};
    Playback playback{reader, "film.mcap", picture};
};

TEST_F(Played, ItPlaysAtItsPaceAndInItsOwnTime) {
    pass(2s);
    EXPECT_EQ(at_ms(), 2000U);
    EXPECT_EQ(home(), "r1");
    EXPECT_EQ(said(), "2000");
    EXPECT_EQ(picture.unix_ms(picture.robots().begin()->second.heard.value()), start_ms + 2000);
    EXPECT_EQ(picture.pace().seconds().back().messages, 10U);
    playback.set_speed(0.1);
    pass(10s);
    EXPECT_NEAR(static_cast<double>(at_ms()), 3000, 1);
    playback.set_speed(100);
    pass(80ms);
    EXPECT_EQ(home(), "r2");
    EXPECT_TRUE(has_happened(HappeningKind::broker_died));
    EXPECT_TRUE(has_happened(HappeningKind::take_over));
}

TEST_F(Played, ItStopsWhenItIsPausedAndAtTheEnd) {
    playback.pause();
    pass(1s);
    EXPECT_EQ(at_ms(), 0U);
    playback.play();
    playback.set_speed(100);
    pass(1s);
    EXPECT_EQ(at_ms(), 20'000U);
    EXPECT_FALSE(picture.recording()->is_playing);
    playback.play();  // from the start
    EXPECT_EQ(at_ms(), 0U);
    EXPECT_EQ(home(), "nowhere");
}

TEST_F(Played, EachPlaceShowsWhatWasKnownThere) {
    playback.pause();
    for (const auto& [to, expected] :
         {std::pair{15'000U, "r2"}, {5'000U, "r1"}, {20'000U, "r2"}, {0U, "nowhere"}}) {
        const std::uint64_t before = picture.version();
        playback.seek(start_ms + to);
        settle();
        EXPECT_EQ(at_ms(), to);
        EXPECT_EQ(home(), expected);
        EXPECT_GT(picture.version(), before) << "who looks gets what is new";
    }
    EXPECT_FALSE(has_happened(HappeningKind::broker_died)) << "that is not so yet";
}

TEST_F(Played, WhoHasSeenWhatIsLaterGetsTheWholeOfWhatIsEarlier) {
    pass(2s);
    const std::uint64_t seen = picture.version();
    playback.seek(start_ms + 1000);
    settle();
    EXPECT_FALSE(changes_since(picture, seen));
    EXPECT_EQ(to_json(picture).at("recording").at("file"), "film.mcap");
}

TEST_F(Played, APlaceOutsideIsTheNearestInside) {
    playback.pause();
    playback.seek(UINT64_MAX);
    settle();
    EXPECT_EQ(at_ms(), 20'000U);
    playback.seek(0);
    settle();
    EXPECT_EQ(at_ms(), 0U);
}

TEST(Playback, OnTheWayFarAheadOnlyStatesCountAndWhatWasSaidLately) {
    Film film;
    film.link(0, true);
    film.robot(1, "abcd1234", "r1");
    film.say(2, "robots/abcd1234/old", "long ago");
    film.say(3'600'000, "robots/abcd1234/new", "lately");
    film.end();
    mcap::Reader reader{film.file};
    FleetPicture picture{Duration{0}};
    Playback playback{reader, "film.mcap", picture};
    playback.seek(UINT64_MAX);
    playback.on_tick(Instant{1h});
    const SeenRobot& robot = picture.robots().begin()->second;
    EXPECT_EQ(robot.home, "r1");
    ASSERT_EQ(robot.messages.size(), 1U);
    EXPECT_EQ(robot.messages.front().text, "lately");
}

TEST(Playback, AGapOfCenturiesIsNoWork) {
    Film film;
    film.link(0, true);
    film.say(3'000'000'000'000, "a", "b");
    film.end();
    mcap::Reader reader{film.file};
    FleetPicture picture{Duration{0}};
    Playback playback{reader, "film.mcap", picture};
    playback.seek(UINT64_MAX);
    playback.on_tick(Instant{1h});
    EXPECT_FALSE(picture.recording()->is_seeking);
}

TEST(Playback, OneTickDoesABoundedPartOfALargeRecording) {
    Film film;
    film.link(0, true);
    for (std::uint64_t i = 0; i < 10'000; ++i) film.say(i / 100, "a", "b");
    film.end();
    mcap::Reader reader{film.file};
    FleetPicture picture{Duration{0}};
    Playback playback{reader, "film.mcap", picture};
    playback.seek(UINT64_MAX);
    playback.on_tick(Instant{1h});
    EXPECT_TRUE(picture.recording()->is_seeking);
    for (int i = 0; i < 10; ++i) playback.on_tick(Instant{1h});
    EXPECT_FALSE(picture.recording()->is_seeking);
}

TEST(Playback, SaysWhatTheRecordingDoesNotHave) {
    Film film;
    film.say(0, "a", "b");
    film.file.append(film.writer.take_chunk());  // and no end
    mcap::Reader reader{film.file};
    FleetPicture picture{Duration{0}};
    Playback playback{reader, "film.mcap", picture};
    EXPECT_THAT(picture.recording()->lost,
                ElementsAre(HasSubstr("not ended: what came after 2025-11-24 16:00:00.000 UTC")));
}

TEST(Playback, OfARecordingThatWasCutBeforeItsFirstChunkSaysSo) {
    Film film;  // its header alone
    mcap::Reader reader{film.file};
    FleetPicture picture{Duration{0}};
    Playback playback{reader, "film.mcap", picture};
    EXPECT_THAT(picture.recording()->lost, ElementsAre(HasSubstr("it holds no whole chunk")));
}

}  // namespace
}  // namespace romano::experiments::playback_test
