// `romano web` with real brokers and robots: through its API, and its page in a real Chromium.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "tests/system/broker_fixture.h"
#include "tests/system/test_client.h"
#include "tests/temporary_folder.h"

namespace romano::system::web_test {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using testing::HasSubstr;
namespace beast = boost::beast;
namespace http = boost::beast::http;

using Clock = std::chrono::steady_clock;
using Response = http::response<http::string_body>;

struct Web : BrokerFixture {
    [[nodiscard]] std::pair<std::string, std::string> at(int broker) const {
        const std::string service = addresses.service(broker);
        const auto colon = service.find(':');
        return {service.substr(0, colon), service.substr(colon + 1)};
    }
    std::unique_ptr<Process> romano(const std::string& command, int broker,
                                    std::vector<std::string> more) const {
        const auto [host, port] = at(broker);
        more.insert(more.begin(), {command, "-h", host, "-p", port});
        return std::make_unique<Process>(ROMANO_PROGRAM, more);
    }
    void start_web(int broker, std::vector<std::string> more = {}) {
        more.insert(more.begin(), {"--listen", "127.0.0.1:0"});
        web = romano("web", broker, std::move(more));
        note_address("the fleet is shown at ");
    }
    void note_address(const std::string& words) {
        const std::string line = web->wait_for(words);
        ASSERT_NE(line, "") << web->errors();
        url = line.substr(line.find("http://"));
        web_port = url.substr(url.rfind(':') + 1);
        web_port.pop_back();  // the slash
    }
    Process& start_robot(const std::string& id, int broker, std::vector<std::string> more = {}) {
        more.insert(more.begin(), {"--id", id, "--broker", addresses.service(broker)});
        robots.push_back(std::make_unique<Process>(ROMANO_ROBOT, more));
        EXPECT_NE(robots.back()->wait_for("established"), "");
        return *robots.back();
    }

    [[nodiscard]] Response ask(http::verb method, const std::string& target,
                               const std::string& body = {}) const {
        boost::asio::io_context io;
        beast::tcp_stream stream(io);
        stream.connect(boost::asio::ip::tcp::resolver(io).resolve("127.0.0.1", web_port));
        http::request<http::string_body> request{method, target, 11, body};
        request.set(http::field::host, "127.0.0.1:" + web_port);
        request.set(http::field::content_type, "application/json");
        request.prepare_payload();
        http::write(stream, request);
        beast::flat_buffer buffer;
        http::response_parser<http::string_body> parser;
        parser.body_limit(64UL << 20U);
        http::read(stream, buffer, parser);
        return parser.release();
    }
    [[nodiscard]] json state() const {
        return json::parse(ask(http::verb::get, "/api/state").body());
    }
    [[nodiscard]] std::string home_of(const std::string& robot) const {
        const json seen = state();
        for (const json& one : seen.at("robots")) {
            if (one.at("robot") == robot) return one.at("home");
        }
        return {};
    }
    [[nodiscard]] bool has_happened(const std::string& kind) const {
        const json seen = state();
        for (const json& one : seen.at("time_line")) {
            if (one.at("kind") == kind) return true;
        }
        return false;
    }
    [[nodiscard]] json last_command() const {
        const json seen = state();
        json last;
        for (const json& one : seen.at("time_line")) {
            if (one.at("kind") == "command") last = one;
        }
        return last;
    }
    /// Asks again and again, until it is so.
    static bool comes(const std::function<bool()>& is_so, std::chrono::seconds limit = 20s) {
        for (const auto end = Clock::now() + limit; Clock::now() < end;) {
            if (is_so()) return true;
            std::this_thread::sleep_for(5ms);
        }
        return false;
    }

    std::vector<std::unique_ptr<Process>> robots;
    std::unique_ptr<Process> web;
    std::string url;
    std::string web_port;
};

TEST_F(Web, ShowsTheNewHomeOfAKilledBrokersRobotsWithinASecond) {
    for (int n = 1; n <= 3; ++n) start_member(n);
    for (const char* id : {"00000001", "00000002"}) start_robot(id, 2);
    start_robot("00000003", 1);
    start_web(3);
    ASSERT_TRUE(comes([&] {
        const json seen = state();
        return seen.at("brokers").size() == 3 && seen.at("robots").size() == 3 &&
               seen.at("cluster").at("members").size() == 3;
    })) << state();
    ASSERT_EQ(home_of("00000001"), "r2");
    EXPECT_TRUE(comes([&] {
        const json seen = state();
        return std::ranges::all_of(seen.at("brokers"), [](const json& broker) {
            return broker.at("longest_turn_ms") > 0 && broker.at("does_not_hear").empty();
        });
    })) << state();
    const auto killed_at = Clock::now();
    brokers[1]->kill_9();
    ASSERT_TRUE(comes([&] { return home_of("00000001") != "r2" && home_of("00000002") != "r2"; }));
    EXPECT_LT(Clock::now() - killed_at, 1s);
    EXPECT_EQ(home_of("00000003"), "r1");
    EXPECT_TRUE(comes([&] { return has_happened("broker-died") && has_happened("take-over"); }));
    // The page's own broker is no other: it goes on when that one dies.
    brokers[2]->kill_9();
    ASSERT_TRUE(comes([&] { return home_of("00000001") == "r1"; })) << state();
    EXPECT_TRUE(state().at("watch").at("is_linked"));
    EXPECT_TRUE(comes([&] { return state().at("cluster").at("leader") == "r1"; }));
}

TEST_F(Web, TellsTheLoadAndTheConditionOfEachBroker) {
    const tests::TemporaryFolder folder;
    std::ofstream(folder / "battery") << "40\n";
    start_member(1, {"--condition-file", (folder / "battery").string()});
    start_member(2);
    start_web(2);
    Process fleet(ROMANO_ROBOT,
                  {"--id", "00000001", "--count", "20", "--broker", addresses.service(1),
                   "--telemetry", "robots/{id}/pose", "--every", "0.01", "--quiet"});
    // In the rank a reading counts in steps of 25. Who has no file is at his best.
    EXPECT_TRUE(comes([&] {
        const json seen = state();
        return std::ranges::all_of(seen.at("brokers"),
                                   [](const json& broker) {
                                       return broker.value("cpu_percent", 0) > 0 &&
                                              broker.value("condition", 0) ==
                                                  (broker.at("name") == "r1" ? 25 : 100);
                                   }) &&
               seen.at("brokers").size() == 2;
    })) << state().at("brokers");
    const std::string table = romano("brokers", 2, {})->rest_of_output();
    EXPECT_THAT(table, HasSubstr(" 25 "));
    EXPECT_THAT(table, HasSubstr(" % "));
}

TEST_F(Web, MovesARobotAndStopsAllAndWhatControlsThem) {
    start_broker(1);
    Process& leader = start_robot("00000001", 1);
    Process& plant = start_robot("00000002", 1);
    start_web(1);
    ASSERT_TRUE(comes([&] { return state().at("robots").size() == 2; }));
    const Response moved = ask(http::verb::post, "/api/robots/00000001/move",
                               R"({"movement": "front", "amount": "10cm"})");
    EXPECT_EQ(moved.result_int(), 202U) << moved.body();
    EXPECT_NE(leader.wait_for("front 100 mm"), "");
    // A machine that is busy with other tests must not break the loop.
    const auto loop =
        romano("control", 1,
               {"00000002", "00000001", "--period-ms", "100", "--deadline-ms", "3000", "--detach"});
    ASSERT_EQ(loop->wait_for_exit(), 0) << loop->errors();
    EXPECT_NE(plant.wait_for("is controlled by 00000001"), "");
    EXPECT_EQ(ask(http::verb::post, "/api/stop").result_int(), 202U);
    EXPECT_NE(leader.wait_for("front 0 mm"), "");
    EXPECT_NE(plant.wait_for("is no longer controlled by 00000001: ended by a node"), "");
    EXPECT_TRUE(comes([&] { return last_command().at("confirmed") == 3; }));
}

TEST_F(Web, StreamsWhatChanges) {
    start_broker(1);
    start_web(1);
    boost::asio::io_context io;
    beast::tcp_stream stream(io);
    stream.connect(boost::asio::ip::tcp::resolver(io).resolve("127.0.0.1", web_port));
    http::request<http::empty_body> request{http::verb::get, "/api/events", 11};
    request.set(http::field::host, "127.0.0.1");
    http::write(stream, request);
    std::string text;
    const auto read_until = [&](const std::string& words) {
        std::array<char, 4096> room{};
        while (text.find(words) == std::string::npos) {
            const std::size_t size =
                stream.socket().read_some(boost::asio::buffer(room));  // ctest limits the time
            text.append(room.data(), size);
        }
    };
    read_until("event: state\ndata: {");
    EXPECT_THAT(text, HasSubstr("Content-Type: text/event-stream"));
    Process& robot = start_robot("abcd1234", 1);
    read_until(R"("robot":"abcd1234")");
    robot.signal(SIGTERM);
    read_until(R"("left":["abcd1234"])");
}

TEST_F(Web, RefusesCommandsWhileNoBrokerAnswersAndGoesOnWhenItIsBack) {
    start_broker(1);
    start_web(1, {"--broker-timeout", "1"});
    ASSERT_TRUE(comes([&] { return state().at("brokers").size() == 1; }));
    brokers[0]->kill_9();
    ASSERT_TRUE(comes([&] { return !state().at("watch").at("is_linked"); }));
    EXPECT_EQ(ask(http::verb::post, "/api/stop").result_int(), 503U);
    start_broker(1);
    ASSERT_TRUE(comes([&] { return state().at("watch").at("is_linked"); }));
    EXPECT_EQ(ask(http::verb::post, "/api/stop").result_int(), 202U);
    EXPECT_TRUE(has_happened("watch-lost"));
    EXPECT_TRUE(has_happened("watch-back"));
    web->signal(SIGTERM);
    EXPECT_EQ(web->wait_for_exit(), 0);
}

/// Those of `file`, in which robots say what they do, that did `what`.
std::set<std::string> who_did(const std::filesystem::path& file, const std::string& what) {
    std::set<std::string> robots;
    std::ifstream stream(file);
    for (std::string line; std::getline(stream, line);) {
        const std::size_t id_end = line.find(' ');
        if (line.find(what) == id_end + 1) robots.insert(line.substr(0, id_end));
    }
    return robots;
}

TEST_F(Web, KnowsTwelveHundredRobotsThatComeAtOnceAndStopsEachOfThem) {
    const tests::TemporaryFolder folder;
    start_broker(1);
    start_web(1);
    Process fleet(
        "/bin/sh",
        {"-c", "exec " ROMANO_ROBOT " --id 00000001 --count 1200 --broker " + addresses.service(1) +
                   " --telemetry 'robots/{id}/pose' --every 5 >" + (folder / "said").string()});
    ASSERT_TRUE(comes([&] { return state().at("robots").size() == 1200; }, 90s))
        << state().at("robots").size();
    const auto listed = romano("robots", 1, {"--json"});
    EXPECT_EQ(json::parse(listed->rest_of_output()).size(), 1200U);

    ASSERT_EQ(ask(http::verb::post, "/api/stop").result_int(), 202U);
    json command;
    EXPECT_TRUE(comes(
        [&] {  // the page is served meanwhile
            command = last_command();
            return command.at("confirmed") == 1201;
        },
        90s))
        << command;
    EXPECT_EQ(command.at("refused"), 0);
    EXPECT_TRUE(comes([&] { return who_did(folder / "said", "front 0 mm").size() == 1200; }));
    // What comes then need not wait for the questions about 1,200 robots' loops.
    ASSERT_EQ(ask(http::verb::post, "/api/robots/00000007/move",
                  R"({"movement": "back", "amount": "10cm"})")
                  .result_int(),
              202U);
    EXPECT_TRUE(
        comes([&] { return who_did(folder / "said", "back 100 mm").contains("00000007"); }));
}

TEST_F(Web, IsServedToThisMachineAloneUnlessItIsToldOtherwise) {
    start_broker(1);
    const auto refused = romano("web", 1, {"--listen", "0.0.0.0:0"});
    EXPECT_EQ(refused->wait_for_exit(), 2);
    EXPECT_THAT(refused->errors(), HasSubstr("whoever reaches the page can steer all robots"));
    const auto open = romano("web", 1, {"--listen", "0.0.0.0:0", "--let-everybody-steer"});
    EXPECT_NE(open->wait_for("http://0.0.0.0:"), "");
    const auto no_address = romano("web", 1, {"--listen", "here"});
    EXPECT_EQ(no_address->wait_for_exit(), 2);
    EXPECT_THAT(no_address->errors(), HasSubstr("--listen `here`: must be an IP address"));
    const auto alone = romano("web", 2, {"--broker-timeout", "0.4"});
    EXPECT_EQ(alone->wait_for_exit(), 2);
    EXPECT_THAT(alone->errors(), HasSubstr("no broker serves at"));
}

/// The page of a broker that shows it itself.
struct WebOfABroker : Web {
    /// `arguments`: all but --web.
    void start_with_page(std::vector<std::string> arguments) {
        arguments.insert(arguments.end(), {"--web", "127.0.0.1:" + web_port});
        brokers.push_back(std::make_unique<BrokerProcess>(arguments));
        brokers.back()->wait_until_serving();
        note_page();
    }
    void note_page() {
        const std::string told = "the fleet is shown at http://127.0.0.1:" + web_port + "/";
        ASSERT_TRUE(comes([&] { return brokers.back()->errors().find(told) != std::string::npos; }))
            << brokers.back()->errors();
    }
    [[nodiscard]] std::vector<std::string> arguments(int n) const {
        return {"--listen", addresses.service(n), "--name", "r" + std::to_string(n)};
    }
    /// The process that a broker started and that is `romano`.
    [[nodiscard]] static pid_t page_of(const Process& broker) {
        const std::string pid = std::to_string(broker.pid());
        std::ifstream children("/proc/" + pid + "/task/" + pid + "/children");
        for (pid_t child = 0; children >> child;) {
            std::ifstream name("/proc/" + std::to_string(child) + "/comm");
            std::string word;
            if (name >> word && word == "romano") return child;
        }
        return 0;
    }
    static bool lives(pid_t process) {  // a dead one that nobody has waited for does not
        std::ifstream file("/proc/" + std::to_string(process) + "/stat");
        std::string stat;
        std::getline(file, stat);  // nothing when it ends meanwhile
        const std::size_t name_end = stat.rfind(')');
        return name_end != std::string::npos && stat.compare(name_end, 3, ") Z") != 0;
    }
    [[nodiscard]] static std::string free_port() {
        boost::asio::io_context io;
        const boost::asio::ip::tcp::acceptor acceptor(
            io, {boost::asio::ip::make_address("127.0.0.1"), 0});
        return std::to_string(acceptor.local_endpoint().port());
    }
    WebOfABroker() { web_port = free_port(); }
};

TEST_F(WebOfABroker, ShowsTheFleetAndLeavesNothingBehind) {
    start_with_page(arguments(1));
    start_robot("00000001", 1);
    ASSERT_TRUE(comes([&] { return home_of("00000001") == "r1"; })) << state();
    const pid_t page = page_of(*brokers[0]);
    ASSERT_NE(page, 0);
    brokers[0]->kill_9();
    EXPECT_TRUE(comes([&] { return !lives(page); }));
    // Also after an orderly end; and the address is free each time.
    start_with_page(arguments(1));
    const pid_t next = page_of(*brokers[1]);
    ASSERT_NE(next, 0);
    brokers[1]->signal(SIGTERM);
    EXPECT_EQ(brokers[1]->wait_for_exit(), 0);
    EXPECT_FALSE(lives(next));
}

TEST_F(WebOfABroker, StartsAPageAgainThatHasEndedAndServesOnMeanwhile) {
    std::vector<std::string> of_a_member = arguments(1);
    of_a_member.insert(of_a_member.end(), {"--domain", std::to_string(addresses.domain()),
                                           "--interface", "lo", "--detection-timeout-ms", "300"});
    start_with_page(of_a_member);
    start_robot("00000001", 1);
    const pid_t page = page_of(*brokers[0]);
    ASSERT_NE(page, 0);
    ASSERT_EQ(::kill(page, SIGKILL), 0);
    ASSERT_TRUE(comes([&] {
        const pid_t next = page_of(*brokers[0]);
        return next != 0 && next != page;
    })) << brokers[0]->errors();
    EXPECT_THAT(brokers[0]->errors(), HasSubstr("was killed by signal 9; it is started again"));
    ASSERT_TRUE(comes([&] {
        try {
            return home_of("00000001") == "r1";
        } catch (const std::exception&) {
            return false;  // not yet
        }
    }));
}

TEST_F(WebOfABroker, IsAKeyOfTheConfigurationFile) {
    const tests::TemporaryFolder folder;
    const std::filesystem::path file = folder / "broker.toml";
    std::ofstream(file) << "listen = [\"" << addresses.service(1) << "\"]\nname = \"r1\"\n"
                        << "web = \"127.0.0.1:" << web_port << "\"\n";
    brokers.push_back(
        std::make_unique<BrokerProcess>(std::vector<std::string>{"--config", file.string()}));
    brokers.back()->wait_until_serving();
    note_page();
    EXPECT_TRUE(comes([&] { return state().at("brokers").size() == 1; }));
}

TEST_F(WebOfABroker, RefusesWhatCannotBeBeforeItServes) {
    start_broker(1, {"--web", "127.0.0.1:" + web_port});
    note_page();
    const auto refusal = [&](const std::string& where) {
        std::vector<std::string> of_another = arguments(2);
        of_another.insert(of_another.end(), {"--web", where});
        Process broker(ROMANO_BROKER, of_another);
        EXPECT_EQ(broker.wait_for_exit(), 2) << where;
        EXPECT_EQ(broker.rest_of_output(), "") << where;
        return broker.errors();
    };
    EXPECT_THAT(refusal("127.0.0.1:" + web_port), HasSubstr("cannot be served (Address already"));
    EXPECT_THAT(refusal("192.0.2.1:80"), HasSubstr("--let-everybody-steer"));
    EXPECT_THAT(refusal("here"), HasSubstr("is no address and port"));
    // Where there is no `romano` beside the broker's program.
    const tests::TemporaryFolder folder;
    const std::filesystem::path alone = folder / "romano-broker";
    std::filesystem::copy_file(ROMANO_BROKER, alone);
    std::vector<std::string> of_another = arguments(2);
    of_another.insert(of_another.end(), {"--web", "127.0.0.1:8080"});
    Process broker(alone, of_another);
    EXPECT_EQ(broker.wait_for_exit(), 2);
    EXPECT_THAT(broker.errors(), HasSubstr("romano, which is not there (No such file"));
    EXPECT_THAT(broker.errors(), HasSubstr("romano-tools"));
}

TEST_F(WebOfABroker, SpeaksWithAKeyToABrokerForClientsWithKeys) {
    const tests::TemporaryFolder folder;
    const std::filesystem::path fleet = folder / "fleet";
    Process keys(ROMANO_PROGRAM, {"keys", "new", fleet.string(), "--broker", "r1", "--robot",
                                  "00000001", "--operator", "anna"});
    ASSERT_EQ(keys.wait_for_exit(), 0) << keys.errors();
    start_with_page({"--listen", "protected://" + addresses.service(1), "--name", "r1", "--keys",
                     (fleet / "brokers/r1").string(), "--web-key",
                     (fleet / "operators/anna.key").string()});
    Process robot(ROMANO_ROBOT, {"--key", (fleet / "robots/00000001.key").string(), "--broker",
                                 addresses.service(1)});
    ASSERT_TRUE(comes([&] { return home_of("00000001") == "r1"; })) << state();
    EXPECT_EQ(ask(http::verb::post, "/api/robots/00000001/move",
                  R"({"movement": "front", "amount": "10cm"})")
                  .result_int(),
              202U);
    EXPECT_NE(robot.wait_for("front 100 mm"), "");
}

/// A recording in which r2, where the robot is, is killed; and its page.
struct WebOfARecording : Web {
    void record_a_death() {
        for (int n = 1; n <= 3; ++n) start_member(n);
        start_robot(robot_id, 2, {"--telemetry", "robots/{id}/pose", "--every", "0.1"});
        const auto recorder = romano("record", 3, {file.string()});
        start_web(3);
        ASSERT_TRUE(comes([&] {
            return home_of(robot_id) == "r2" && state().at("cluster").at("members").size() == 3;
        })) << state();
        std::this_thread::sleep_for(3s);  // of the recording, so that the death is news in it
        brokers[1]->kill_9();
        ASSERT_TRUE(comes([&] { return home_of(robot_id) == "r1" || home_of(robot_id) == "r3"; }));
        heir = home_of(robot_id);
        std::this_thread::sleep_for(1s);
        recorder->signal(SIGINT);
        ASSERT_EQ(recorder->wait_for_exit(), 0) << recorder->errors();
        web->signal(SIGTERM);
        ASSERT_EQ(web->wait_for_exit(), 0);
    }
    void open_recording() {
        web = std::make_unique<Process>(
            ROMANO_PROGRAM, std::vector<std::string>{"web", "--recording", file.string(),
                                                     "--listen", "127.0.0.1:0"});
        note_address("the recording is shown at ");
    }
    void seek(std::uint64_t unix_ms) {
        const std::string wish = json{{"play", false}, {"at_unix_ms", unix_ms}}.dump();
        ASSERT_EQ(ask(http::verb::post, "/api/recording", wish).result_int(), 202U);
        ASSERT_TRUE(comes([&] {
            const json at = state().at("recording");
            return !at.at("is_seeking").get<bool>() && !at.at("is_playing").get<bool>();
        }));
    }

    const std::string robot_id = "00000001";
    tests::TemporaryFolder folder;
    std::filesystem::path file = folder / "test.mcap";
    std::string heir;
};

TEST_F(WebOfARecording, ShowsEachPlaceOfItAndPlays) {
    record_a_death();
    open_recording();
    const json recording = state().at("recording");
    EXPECT_EQ(recording.at("file"), "test.mcap");
    const auto end = recording.at("end_unix_ms").get<std::uint64_t>();
    seek(end);
    EXPECT_EQ(home_of(robot_id), heir);
    EXPECT_TRUE(has_happened("broker-died"));
    EXPECT_TRUE(has_happened("take-over"));
    std::uint64_t died_unix_ms = 0;
    const json seen = state();
    for (const json& one : seen.at("time_line")) {
        if (one.at("kind") == "broker-died") died_unix_ms = one.at("unix_ms");
    }
    seek(died_unix_ms - 500);
    EXPECT_EQ(home_of(robot_id), "r2");
    EXPECT_FALSE(has_happened("broker-died"));
    EXPECT_TRUE(
        json::parse(ask(http::verb::get, "/api/robots/" + robot_id).body()).contains("place"));
    EXPECT_EQ(
        ask(http::verb::post, "/api/recording", R"({"play": true, "speed": 100})").result_int(),
        202U);
    EXPECT_TRUE(comes([&] { return home_of(robot_id) == heir; }));
    EXPECT_TRUE(comes([&] { return !state().at("recording").at("is_playing").get<bool>(); }));
    EXPECT_EQ(ask(http::verb::post, "/api/stop").result_int(), 409U);
}

#ifdef PAGE_TEST
TEST_F(WebOfARecording, InARealBrowser) {
    record_a_death();
    open_recording();
    ::setenv("PAGE_TEST_MODULES", PAGE_TEST_MODULES, 1);
    ::setenv("CHROMIUM", CHROMIUM_PROGRAM, 1);
    Process page(NODE_PROGRAM, {RECORDING_PAGE_TEST, url, robot_id, heir});
    for (const char* seen : {"the end shows what happened", "the beginning knows nothing of it",
                             "it says who talks to whom", "it plays and is paused"}) {
        ASSERT_NE(page.wait_for(seen, 60s), "") << seen << ": " << page.errors();
    }
    EXPECT_EQ(page.wait_for_exit(), 0) << page.errors();
}

TEST_F(Web, ThePageInARealBrowser) {
    for (int n = 1; n <= 3; ++n) start_member(n);
    const std::string robot_id = "00000001";
    const std::string hostile_id = "0badf00d";
    start_robot(robot_id, 2, {"--telemetry", "robots/{id}/pose", "--every", "0.1"});
    TestClient hostile{addresses.client(), addresses.service_endpoint(1),
                       "<img src=x onerror=alert(1)>"};
    ASSERT_TRUE(hostile.connect());
    ASSERT_TRUE(hostile.subscribe(hostile_id, mqttsn::Qos::at_least_once));
    const auto init = hostile.register_topic("init-info");
    ASSERT_TRUE(init);
    ASSERT_TRUE(hostile.publish(*init, std::string("\x0B\x0A", 2) + hostile_id,
                                mqttsn::Qos::at_least_once));
    start_web(3);
    ASSERT_TRUE(comes([&] { return home_of(hostile_id) == "r1" && home_of(robot_id) == "r2"; }))
        << state();
    const auto say = [&](const std::string& topic, const std::string& data) {
        const auto id = hostile.register_topic(hostile_id + '/' + topic);
        ASSERT_TRUE(id) << topic.size();
        ASSERT_TRUE(hostile.publish(*id, data, mqttsn::Qos::at_least_once));
    };
    say("\x1b[31m\xe2\x80\xae", "<script>alert(2)</script>");
    say("long", std::string(60'000, '<'));
    say(std::string(60'000 - hostile_id.size() - 1, 'x'), "a long name");

    ::setenv("PAGE_TEST_MODULES", PAGE_TEST_MODULES, 1);
    ::setenv("CHROMIUM", CHROMIUM_PROGRAM, 1);
    Process page(NODE_PROGRAM, {PAGE_TEST, url, robot_id, hostile_id});
    for (const char* seen : {"the fleet is shown", "hostile names are text", "it fits a phone",
                             "a keyboard is enough", "a screen reader is told"}) {
        ASSERT_NE(page.wait_for(seen, 60s), "") << seen << ": " << page.errors();
    }
    ASSERT_NE(page.wait_for("home is r2"), "") << page.errors();
    const auto killed_at = Clock::now();
    brokers[1]->kill_9();
    const std::string line = page.wait_for("home is now ");
    const auto took = Clock::now() - killed_at;
    ASSERT_NE(line, "") << page.errors();
    EXPECT_LT(took, 3s);  // a second, and what sanitizers and other tests take
    std::printf("the page showed the new home after %lld ms\n",
                static_cast<long long>(
                    std::chrono::duration_cast<std::chrono::milliseconds>(took).count()));
    ASSERT_NE(page.wait_for("the time line tells of the take-over"), "") << page.errors();
    web->kill_9();
    ASSERT_NE(page.wait_for("the page says that it is alone"), "") << page.errors();
    EXPECT_EQ(page.wait_for_exit(), 0) << page.errors();
}

TEST_F(Web, AFrameOfThePageWithTwoHundredRobotsNeedsLessThan16Ms) {
    start_broker(1);
    start_web(1);
    Process fleet(ROMANO_ROBOT,
                  {"--id", "00000001", "--count", "200", "--broker", addresses.service(1),
                   "--telemetry", "robots/{id}/pose", "--every", "0.1", "--quiet"});
    ASSERT_TRUE(comes([&] { return state().at("robots").size() == 200; }, 60s))
        << state().at("robots").size();
    ::setenv("PAGE_TEST_MODULES", PAGE_TEST_MODULES, 1);
    ::setenv("CHROMIUM", CHROMIUM_PROGRAM, 1);
    Process page(NODE_PROGRAM, {FRAMES_TEST, url, "200"});
    std::printf("%s\n", page.wait_for("frames of", 120s).c_str());
    EXPECT_EQ(page.wait_for_exit(), 0) << page.errors();
}
#endif

}  // namespace
}  // namespace romano::system::web_test
