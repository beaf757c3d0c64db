// `romano record` and `romano replay` with real brokers: what was published is recorded, read by a
// reader that others wrote, and published again exactly; whatever kills the recorder.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "experiments/recording/recorded_message.h"
#include "tests/experiments/mcap/files_in_memory.h"
#include "tests/system/broker_fixture.h"
#include "tests/system/test_client.h"
#include "tests/temporary_folder.h"

namespace romano::system::recording_test {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using testing::HasSubstr;
using Clock = std::chrono::steady_clock;

struct Recordings : BrokerFixture {
    [[nodiscard]] std::vector<std::string> arguments(const std::string& command, int broker,
                                                     const std::vector<std::string>& more) const {
        const std::string service = addresses.service(broker);
        const auto colon = service.find(':');
        std::vector<std::string> all{command, file.string(),
                                     "-h",    service.substr(0, colon),
                                     "-p",    service.substr(colon + 1)};
        all.insert(all.end(), more.begin(), more.end());
        return all;
    }
    std::unique_ptr<Process> romano(const std::string& command, int broker,
                                    const std::vector<std::string>& more = {}) const {
        return std::make_unique<Process>(ROMANO_PROGRAM, arguments(command, broker, more));
    }
    /// What it says in the end.
    [[nodiscard]] json replay(int broker, std::vector<std::string> more = {}) const {
        more.emplace_back("--json");
        const auto process = romano("replay", broker, more);
        const std::string line = process->next_line(60s);
        EXPECT_EQ(process->wait_for_exit(), 0) << process->errors();
        return json::parse(line, nullptr, false);
    }

    std::unique_ptr<TestClient> client(int broker, const std::string& id) {
        auto made = std::make_unique<TestClient>(addresses.client(),
                                                 addresses.service_endpoint(broker), id);
        EXPECT_TRUE(made->connect());
        return made;
    }
    static void say(TestClient& client, const std::string& topic, const std::string& data,
                    mqttsn::Qos qos = mqttsn::Qos::at_least_once, bool retain = false) {
        const auto id = client.register_topic(topic);
        ASSERT_TRUE(id) << topic.substr(0, 100);
        ASSERT_TRUE(client.publish(*id, data, qos, retain)) << topic.substr(0, 100);
    }

    /// A recorder that hears: it has written down a message of `probe`.
    void start_recorder(TestClient& probe, std::vector<std::string> more = {}) {
        recorder = romano("record", 1, more);
        wait_until_it_has_heard_all(probe);
    }
    /// The first chunk may have been begun before what was said last; the second is later.
    void wait_until_it_has_heard_all(TestClient& probe) {
        for (int chunk = 0; chunk < 2; ++chunk) wait_until_it_hears(probe);
    }
    void end_recorder(TestClient& probe, int signal = SIGINT) {
        wait_until_it_has_heard_all(probe);
        recorder->signal(signal);
        ASSERT_NE(recorder->wait_for(" messages, "), "") << recorder->errors();
        ASSERT_EQ(recorder->wait_for_exit(), 0) << recorder->errors();
    }
    void wait_until_it_hears(TestClient& probe) {
        const auto size = [this] {
            std::error_code none;
            const auto octets = std::filesystem::file_size(file, none);
            return none ? 0 : octets;
        };
        const auto end = Clock::now() + 30s;
        std::uintmax_t before = 0;
        while (Clock::now() < end && before == 0) {  // the states that brokers keep come first
            std::this_thread::sleep_for(50ms);
            before = size();
        }
        for (before = size(); Clock::now() < end && size() <= before;) {
            say(probe, "probe", "1");
            std::this_thread::sleep_for(100ms);
        }
        ASSERT_GT(size(), before) << recorder->errors();
    }

    tests::TemporaryFolder folder;
    std::filesystem::path file = folder / "test.mcap";
    std::unique_ptr<Process> recorder;
};

/// What a test says, hears and reads.
struct Said {
    std::string topic;
    std::string data;
    mqttsn::Qos qos;
};

std::vector<Said> all_kinds() {
    std::string all;
    for (int octet = 0; octet < 256; ++octet) all += static_cast<char>(octet);
    return {{"robots/abcd1234/pose", "x=1 y=2", mqttsn::Qos::at_most_once},
            {"robots/abcd1234/pose", "x=2 y=2", mqttsn::Qos::at_least_once},
            {"json", R"({"x": 1.5})", mqttsn::Qos::exactly_once},
            {"octets", all, mqttsn::Qos::at_least_once},
            {"\x1b[31m<script>\xe2\x80\xae", "", mqttsn::Qos::at_least_once},
            {std::string(60'000, 'x'), "a long name", mqttsn::Qos::at_least_once},
            {"long", std::string(60'000, '<'), mqttsn::Qos::at_least_once}};
}

TEST_F(Recordings, AreReplayedExactlyAsTheyWerePublished) {
    start_broker(1);
    const auto talker = client(1, "talker");
    say(*talker, "kept", "before", mqttsn::Qos::at_least_once, true);
    start_recorder(*talker);
    for (const Said& said : all_kinds()) say(*talker, said.topic, said.data, said.qos);
    end_recorder(*talker);

    start_broker(2);
    const auto listener = client(2, "listener");
    ASSERT_TRUE(listener->subscribe("#", mqttsn::Qos::exactly_once));
    const json told = replay(2, {"--speed", "100"});
    EXPECT_EQ(told.value("refused", -1), 0) << told;
    EXPECT_EQ(told.value("foreign", -1), 0) << told;
    EXPECT_TRUE(told.at("lost").empty()) << told;
    ASSERT_TRUE(listener->run_until(
        [&] { return !listener->received.empty() && listener->received.back().topic == "long"; }));
    std::vector<ReceivedPublish> heard = listener->received;
    std::erase_if(heard, [](const ReceivedPublish& one) {
        return one.topic == "probe" || one.topic == "kept";
    });
    const std::vector<Said> said = all_kinds();
    ASSERT_EQ(heard.size(), said.size());
    for (std::size_t i = 0; i < said.size(); ++i) {
        EXPECT_EQ(heard[i].topic, said[i].topic) << i;
        EXPECT_EQ(heard[i].data, said[i].data) << i;
        EXPECT_EQ(heard[i].qos, said[i].qos) << i;
    }
    // What the broker had kept is kept again.
    const auto late = client(2, "late");
    ASSERT_TRUE(late->subscribe("kept", mqttsn::Qos::at_least_once));
    ASSERT_TRUE(late->run_until([&] { return !late->received.empty(); }));
    EXPECT_EQ(late->received.front().data, "before");
    EXPECT_TRUE(late->received.front().retain);
}

TEST_F(Recordings, AreReplayedWithoutWhatMovesRobotsUnlessThatIsAskedFor) {
    start_broker(1);
    const auto talker = client(1, "talker");
    start_recorder(*talker);
    const std::string movement{"\x07\x08\x00\x00\x00\x00\x00\x64", 8};
    say(*talker, "abcd1234", movement);
    say(*talker, "team/red", movement);
    say(*talker, "pose", "x=1");
    end_recorder(*talker, SIGTERM);

    start_broker(2);
    const auto robot = client(2, "abcd1234");
    ASSERT_TRUE(robot->subscribe("abcd1234", mqttsn::Qos::at_least_once));
    ASSERT_TRUE(robot->subscribe("team/red", mqttsn::Qos::at_least_once));
    ASSERT_TRUE(robot->subscribe("pose", mqttsn::Qos::at_least_once));
    const json told = replay(2, {"--speed", "100"});
    EXPECT_EQ(told.value("held_back", -1), 2) << told;
    ASSERT_TRUE(robot->run_until([&] { return !robot->received.empty(); }));
    EXPECT_EQ(robot->received.front().topic, "pose");
    robot->received.clear();
    EXPECT_EQ(replay(2, {"--speed", "100", "--steer", "--topics", "abcd1234", "--topics", "team/#"})
                  .value("published", -1),
              2);
    ASSERT_TRUE(robot->run_until([&] { return robot->received.size() >= 2; }));
    EXPECT_EQ(robot->received.front().data, movement);
}

/// A minute and more of a recording, made in no time.
void write_recording(const std::filesystem::path& file,
                     const std::vector<std::pair<std::chrono::milliseconds, std::string>>& poses) {
    namespace mcap = experiments::mcap;
    mcap::FileInMemory made;
    mcap::ChunkWriter writer{experiments::recording_schema(),
                             std::string{experiments::recording_encoding}};
    made.append(writer.beginning("test"));
    for (const auto& [at, text] : poses) {
        const auto time = static_cast<mcap::Timestamp>(std::chrono::nanoseconds{at + 1h}.count());
        const std::string told =
            experiments::recorded_text("pose", as_octets(text), mqttsn::Qos::at_least_once, false);
        (void)writer.add(time, "pose", "name", as_octets(told));
    }
    made.append(writer.take_chunk());
    made.finish();
    std::ofstream(file, std::ios::binary) << as_text(made.octets);
}

// The whole replay is timed: a busy machine makes it later, and never too early.
TEST_F(Recordings, KeepTheirPaceFromATenthToAHundredTimes) {
    start_broker(2);
    const auto listener = client(2, "listener");
    // It looks when a replay is over: what it does not acknowledge is sent again.
    ASSERT_TRUE(listener->subscribe("pose", mqttsn::Qos::at_most_once));
    const auto replay_lasts = [&](std::chrono::milliseconds length, const std::string& speed) {
        write_recording(file, {{0ms, "first"}, {length, "last"}});
        listener->received.clear();
        const auto began = Clock::now();
        const json told = replay(2, {"--speed", speed});
        const auto lasted = Clock::now() - began;
        EXPECT_EQ(told.value("published", 0), 2) << told;
        EXPECT_TRUE(listener->run_until([&] { return listener->received.size() == 2; }));
        EXPECT_EQ(listener->received.back().data, "last");
        return lasted;
    };
    EXPECT_GE(replay_lasts(200ms, "0.1"), 2s);
    EXPECT_GE(replay_lasts(500ms, "1"), 500ms);
    const auto a_hundred_times = replay_lasts(100s, "100");
    EXPECT_GE(a_hundred_times, 1s);
    EXPECT_LT(a_hundred_times, 50s);
}

TEST_F(Recordings, OfAKilledRecorderHoldAllButTheLastSecond) {
    start_broker(1);
    const auto talker = client(1, "talker");
    start_recorder(*talker);
    say(*talker, "pose", "written");
    wait_until_it_has_heard_all(*talker);
    recorder->kill_9();
    start_broker(2);
    const auto listener = client(2, "listener");
    ASSERT_TRUE(listener->subscribe("pose", mqttsn::Qos::at_least_once));
    const json told = replay(2, {"--speed", "100"});
    ASSERT_EQ(told.at("lost").size(), 1U) << told;
    EXPECT_THAT(told.at("lost").front().get<std::string>(), HasSubstr("was not ended"));
    ASSERT_TRUE(listener->run_until([&] { return !listener->received.empty(); }));
    EXPECT_EQ(listener->received.front().data, "written");
}

TEST_F(Recordings, OnAFullDiskKeepWhatCameBefore) {
    start_broker(1);
    const auto talker = client(1, "talker");
    std::string command = "ulimit -f 64; exec " + std::string{ROMANO_PROGRAM};  // KiB
    for (const std::string& argument : arguments("record", 1, {})) command += " '" + argument + "'";
    recorder = std::make_unique<Process>("/bin/bash", std::vector<std::string>{"-c", command});
    say(*talker, "pose", "kept");
    wait_until_it_has_heard_all(*talker);
    // Octets that cannot be made smaller: a chunk of them is larger than what is left.
    std::string noise(50'000, '\0');
    std::uint32_t state = 1;
    for (int i = 0; i < 4; ++i) {
        for (char& octet : noise) {
            state = state * 1664525U + 1013904223U;
            octet = static_cast<char>(state >> 24U);
        }
        say(*talker, "noise", noise);
    }
    EXPECT_EQ(recorder->wait_for_exit(60s), 2);
    EXPECT_THAT(recorder->errors(), HasSubstr("File too large: what came before is in it"));
    start_broker(2);
    const json told = replay(2, {"--speed", "100"});
    EXPECT_TRUE(told.at("lost").empty()) << "there was room for its end: " << told;
    EXPECT_GE(told.value("published", 0), 3) << told;
}

TEST_F(Recordings, AreRefusedInOneSentence) {
    start_broker(1);
    const auto fails = [](Process& process, const std::string& words) {
        EXPECT_EQ(process.wait_for_exit(), 2);
        EXPECT_THAT(process.errors(), HasSubstr(words));
    };
    fails(*romano("replay", 1), "test.mcap`: No such file or directory");
    { std::ofstream{file} << "no recording"; }
    fails(*romano("replay", 1), "is no recording: it does not begin as MCAP");
    fails(*romano("record", 1), "is there already");
    fails(*romano("replay", 1, {"--speed", "200"}), "--speed");
    fails(*romano("replay", 1, {"--topics", "a/#/b"}), "--topics `a/#/b`: must be a topic filter");
    std::filesystem::remove(file);
    fails(*romano("record", 2, {"--broker-timeout", "0.4"}), "no broker serves at");
    EXPECT_FALSE(std::filesystem::exists(file)) << "nothing is half-started";
}

#ifdef MCAP_TEST
/// What a reader that others wrote finds in a recording.
struct RecordingsForOthers : Recordings {
    RecordingsForOthers() { ::setenv("MCAP_TEST_MODULES", MCAP_TEST_MODULES, 1); }

    /// By its index, or as it stands: {"--from-start"}.
    [[nodiscard]] std::vector<json> read(std::vector<std::string> how) const {
        how.insert(how.begin(), MCAP_TEST);
        how.push_back(file);
        Process reader(NODE_PROGRAM, how);
        std::vector<json> messages;
        std::istringstream lines(reader.rest_of_output());
        for (std::string line; std::getline(lines, line);) messages.push_back(json::parse(line));
        EXPECT_EQ(reader.wait_for_exit(60s), 0) << reader.errors();
        return messages;
    }
    /// They are what was said, and have the times at which they were said.
    void check(std::vector<json> messages) const {
        std::erase_if(messages, [](const json& one) {
            const std::string topic = one.at("topic");
            return topic == "probe" || topic.starts_with('$') || one.at("kind") == "recorder";
        });
        const std::vector<Said> said = all_kinds();
        ASSERT_EQ(messages.size(), said.size());
        for (std::size_t i = 0; i < said.size(); ++i) {
            EXPECT_EQ(messages[i].at("topic"), said[i].topic);
            EXPECT_EQ(messages[i].at("kind"), "name");
            EXPECT_EQ(messages[i].at("qos"), static_cast<int>(said[i].qos));
            EXPECT_GE(messages[i].at("time_ms").get<std::int64_t>(), began_unix_ms);
            EXPECT_LE(messages[i].at("time_ms").get<std::int64_t>(), unix_ms());
            if (!messages[i].contains("text")) continue;
            EXPECT_EQ(messages[i].at("text"), said[i].data);
        }
        EXPECT_EQ(messages[2].at("json").at("x"), 1.5);
        EXPECT_EQ(messages[3].at("octets").get<std::string>().size(), 512U);
    }
    /// How many messages our own reader finds.
    [[nodiscard]] std::size_t count_by_replay(int broker) const {
        const json told = replay(broker, {"--speed", "100"});
        std::size_t count = 0;
        for (const char* what :
             {"published", "held_back", "of_brokers", "not_asked_for", "foreign", "refused"}) {
            count += told.at(what).get<std::size_t>();
        }
        return count;
    }
    [[nodiscard]] static std::int64_t unix_ms() {
        return std::chrono::duration_cast<std::chrono::milliseconds>(
                   std::chrono::system_clock::now().time_since_epoch())
            .count();
    }

    std::int64_t began_unix_ms = unix_ms();
};

TEST_F(RecordingsForOthers, AreReadByTheirIndexAndFromTheirStart) {
    start_broker(1);
    const auto talker = client(1, "talker");
    start_recorder(*talker);
    for (const Said& said : all_kinds()) say(*talker, said.topic, said.data, said.qos);
    end_recorder(*talker);
    check(read({}));
    check(read({"--from-start"}));
    // Cut in the middle of its end: what is whole is read.
    std::filesystem::resize_file(file, std::filesystem::file_size(file) - 100);
    check(read({"--from-start"}));
}

TEST_F(RecordingsForOthers, AreReadThoughTheirRecorderWasKilledAndTheyAreCutInTheMiddle) {
    start_broker(1);
    const auto talker = client(1, "talker");
    start_recorder(*talker);
    for (const Said& said : all_kinds()) say(*talker, said.topic, said.data, said.qos);
    wait_until_it_has_heard_all(*talker);
    recorder->kill_9();
    const std::vector<json> whole = read({"--from-start"});
    check(whole);
    const auto size = std::filesystem::file_size(file);
    std::size_t before = whole.size();
    for (const std::uintmax_t tenths : {9U, 5U, 1U}) {  // in a chunk, or behind one
        std::filesystem::resize_file(file, size * tenths / 10);
        const std::vector<json> left = read({"--from-start"});
        ASSERT_LE(left.size(), before);
        EXPECT_TRUE(std::equal(left.begin(), left.end(), whole.begin())) << "nothing is made up";
        EXPECT_EQ(count_by_replay(1), left.size()) << "our reader finds as much, " << tenths;
        before = left.size();
    }
    EXPECT_LT(before, whole.size());
}
#endif

}  // namespace
}  // namespace romano::system::recording_test
