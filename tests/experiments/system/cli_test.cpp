// The operator's program as people call it, against a real broker.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "experiments/sweep/csv.h"
#include "tests/experiments/system/processes.h"
#include "tests/temporary_folder.h"

namespace romano::experiments::cli_test {
namespace {

using ::testing::HasSubstr;

class Cli : public ::testing::Test {
protected:
    const std::string address_ = "127.50.250.1";
    const std::string at_ = "-h " + address_ + " -p " + own_port() + " ";
    ServingBroker broker_{address_};
};

TEST_F(Cli, PublishesWhatItRetainsAndSubscribesToIt) {
    for (const char* qos : {"0", "1", "2"}) {
        const std::string topic = std::string{"kept/"} + qos;
        EXPECT_EQ(
            run_romano("pub " + at_ + "-r -q " + qos + " -t " + topic + " -m 'two words'").output,
            "");
        const Ran sub = run_romano("sub " + at_ + "-v -C 1 -W 20 -q 2 -t " + topic);
        EXPECT_EQ(sub.output, topic + " two words\n");
        EXPECT_EQ(sub.exit_code, 0);
    }
}

TEST_F(Cli, DeliversLinesOfStandardInputInOrder) {
    // A kept session collects them while its subscriber is away: nobody needs to wait for him.
    const std::string keeper = at_ + "-i keeper -c -q 1 -t lines ";
    EXPECT_EQ(run_romano("sub " + keeper + "-W 0.5").exit_code, 27);
    const tests::TemporaryFolder folder;
    const auto file = folder / "lines";
    std::ofstream(file) << "one\ntwo\nthree";
    EXPECT_EQ(run_romano("pub " + at_ + "-q 1 -t lines -l < " + file.string()).output, "");
    EXPECT_EQ(run_romano("sub " + keeper + "-C 3 -W 20").output, "one\ntwo\nthree\n");
}

TEST_F(Cli, ShowsTheBrokerAsTableAndAsJson) {
    const Ran table = run_romano("brokers " + at_);
    EXPECT_EQ(table.exit_code, 0);
    EXPECT_THAT(table.output, HasSubstr("b1  alive  leader"));
    EXPECT_THAT(table.output, HasSubstr(address_ + ":" + own_port()));
    EXPECT_THAT(table.output, HasSubstr("led by b1: b1"));
    const auto json = nlohmann::json::parse(run_romano("brokers --json " + at_).output);
    EXPECT_EQ(json.at(0).at("name"), "b1");
}

TEST_F(Cli, ShowsHowTheBrokerIsDoing) {
    EXPECT_EQ(run_romano("pub " + at_ + "-r -q 1 -t kept/status -m x").output, "");
    const std::string metrics = "status " + address_ + ":" + own_port() + " ";
    const Ran screen = run_romano(metrics + "--every 0.2");
    EXPECT_EQ(screen.exit_code, 0) << screen.output;
    EXPECT_THAT(screen.output, HasSubstr("broker    b1, version "));
    EXPECT_THAT(screen.output, HasSubstr("messages  "));
    EXPECT_THAT(screen.output, HasSubstr("drops     none"));
    const auto json = nlohmann::json::parse(run_romano(metrics + "--json").output);
    EXPECT_EQ(json.at("romano_publishes_received_total").at(0).at("value"), 1);
}

TEST_F(Cli, EndsWithItsOwnCodeWhenTimeRunsOut) {
    EXPECT_EQ(run_romano("sub " + at_ + "-t nothing -W 2").exit_code, 27);
}

TEST_F(Cli, SaysRomanoMessagesInWords) {
    const tests::TemporaryFolder folder;
    const std::string file = folder / "location";
    const std::string octets("\x06\x10\0\x02\0\0\0\x01\0\0\0\x02\0\0\0\x03", 16);
    std::ofstream(file, std::ios::binary) << octets;
    EXPECT_EQ(run_romano("pub " + at_ + "-r -q 1 -t pose -f " + file).output, "");
    const std::string sub = "sub " + at_ + "-C 1 -W 20 -q 1 -t pose ";
    EXPECT_EQ(run_romano(sub + "-v").output,
              "pose sensor-data sensor=location x_mm=1 y_mm=2 heading_mdeg=3\n");
    EXPECT_EQ(run_romano(sub + "--raw").output, octets + "\n");
    const auto json = nlohmann::json::parse(run_romano(sub + "--json").output);
    EXPECT_EQ(json.at("topic"), "pose");
    EXPECT_EQ(json.at("retain"), true);
    EXPECT_EQ(json.at("romano").at("y_mm"), 2);
}

TEST_F(Cli, JsonHasTextsAsTextsAndOtherOctetsAsHexadecimalDigits) {
    EXPECT_EQ(run_romano("pub " + at_ + "-r -q 1 -t kept/text -m 'x=1'").output, "");
    EXPECT_EQ(
        run_romano("pub " + at_ + "-r -q 1 -t kept/octets -m \"$(printf '\\377\\001')\"").output,
        "");
    const std::string sub = "sub " + at_ + "-C 1 -W 20 -q 1 --json -t kept/";
    EXPECT_EQ(nlohmann::json::parse(run_romano(sub + "text").output).at("text"), "x=1");
    EXPECT_THAT(run_romano(sub + "octets").output, HasSubstr("\"octets\":\""));
}

// A subscriber whose time is up or who is interrupted does not wait for a broker that is dead.
TEST_F(Cli, SubscriberEndsAtOnceThoughItsBrokerIsDead) {
    auto broker = std::make_unique<ServingBroker>("127.50.250.2");
    const std::string at = "-h 127.50.250.2 -p " + own_port();
    EXPECT_EQ(run_romano("pub " + at + " -r -q 1 -t kept -m here").output, "");
    const std::string command = std::string{ROMANO_PROGRAM} + " sub " + at + " -t kept -W 2";
    std::FILE* output = ::popen(command.c_str(), "r");
    ASSERT_NE(output, nullptr);
    std::array<char, 64> line{};
    ASSERT_NE(std::fgets(line.data(), line.size(), output), nullptr) << "it is connected";
    broker.reset();
    const auto began = std::chrono::steady_clock::now();
    EXPECT_EQ(WEXITSTATUS(::pclose(output)), 27);
    EXPECT_LT(std::chrono::steady_clock::now() - began, std::chrono::seconds{5});
}

struct FullBroker : ::testing::TestWithParam<const char*> {};

TEST_P(FullBroker, IsSaidToBeFull) {
    const ServingBroker broker("127.50.250.3", {"--max-sessions", "1"});
    const std::string at = " -h 127.50.250.3 -p " + own_port();
    // A kept session takes the only place.
    EXPECT_EQ(run_romano("sub" + at + " -i keeper -c -t a -W 0.5").exit_code, 27);
    const Ran ran = run_romano(GetParam() + at);
    EXPECT_EQ(ran.exit_code, 2);
    EXPECT_THAT(ran.output, HasSubstr("congestion"));
    EXPECT_EQ(std::count(ran.output.begin(), ran.output.end(), '\n'), 1) << ran.output;
}

INSTANTIATE_TEST_SUITE_P(Commands, FullBroker,
                         ::testing::Values("pub -t a -m b", "sub -t a", "brokers", "robots",
                                           "robots --follow", "move common front 1m",
                                           "request common t location", "load --rate 10",
                                           "apply group-control"));

struct BrokerWithoutRoom : ::testing::TestWithParam<const char*> {};

// What is refused with "congestion" would be asked for again after T_WAIT, minutes later.
TEST_P(BrokerWithoutRoom, IsSaidToBeFull) {
    // $SYS/brokers/b1 is the only retained message.
    const ServingBroker broker("127.50.250.4", {"--max-retained", "1", "--max-subscriptions", "1"});
    const Ran ran = run_romano(GetParam() + (" -h 127.50.250.4 -p " + own_port()));
    EXPECT_EQ(ran.exit_code, 2);
    EXPECT_THAT(ran.output, HasSubstr("congestion"));
    EXPECT_EQ(std::count(ran.output.begin(), ran.output.end(), '\n'), 1) << ran.output;
}

INSTANTIATE_TEST_SUITE_P(Commands, BrokerWithoutRoom,
                         ::testing::Values("pub -t a -m b -q 1 -r", "sub -t a -t b -W 60",
                                           "robots --follow", "move abcd1234 front 1m --wait 60"));

// The broker need not wait for the end of their keep-alive.
TEST_F(Cli, RefusedCommandsSayGoodbye) {
    EXPECT_EQ(run_romano("pub " + at_ + "-q 1 -t '$SYS/no' -m x").exit_code, 2);
    EXPECT_EQ(run_romano("sub " + at_ + "--predefined 9").exit_code, 2);
    EXPECT_EQ(run_romano("move " + at_ + "abcd1234 front 1m").exit_code, 2);
    const Ran screen = run_romano("status " + address_ + ":" + own_port() + " --every 0.2");
    EXPECT_THAT(screen.output, HasSubstr("sessions  3 disconnected"));
}

TEST(Simulate, IsTheSameByteForByteForTheSameSeed) {
    const Ran once = run_romano("simulate --seeds 3 --fault crash --trace");
    EXPECT_EQ(once.exit_code, 0);
    EXPECT_THAT(once.output, HasSubstr("crashes"));
    EXPECT_EQ(run_romano("simulate --seeds 3 --fault crash --trace").output, once.output);
}

TEST(Simulate, CountsRunsByFault) {
    const Ran table = run_romano("simulate --seeds 1..3 --fault stop --fault leave");
    EXPECT_EQ(table.exit_code, 0);
    EXPECT_THAT(table.output, HasSubstr("stop"));
    const Ran ran = run_romano("simulate --seeds 1..3 --fault stop --fault leave --json");
    const auto json = nlohmann::json::parse(ran.output);
    EXPECT_EQ(json.at("runs").at("all"), 3);
    EXPECT_EQ(json.at("runs").at("bad"), 0);
    EXPECT_GT(json.at("faults").at("leave").at("times"), 0);
    EXPECT_FALSE(json.at("faults").contains("crash"));
}

TEST(Simulate, CountsInHowManyRunsOfEachConfigurationAnInvariantBroke) {
    const std::string command = "simulate --seeds 1..3 --as-shipped --profile wifi --invariants";
    const Ran table = run_romano(command);
    EXPECT_THAT(table.output, HasSubstr("Runs in which an invariant broke"));
    EXPECT_THAT(table.output, HasSubstr("wifi"));
    const auto json = nlohmann::json::parse(run_romano(command + " --json").output);
    int runs = 0;
    for (const auto& configuration : json.at("invariants")) {
        EXPECT_EQ(configuration.at("profile"), "wifi");
        EXPECT_TRUE(configuration.at("broken").contains("I1 one speaker"));
        runs += configuration.at("runs").get<int>();
    }
    EXPECT_EQ(runs, 3);
}

TEST(Cost, LeavesNumbersAndPictureOfEachCountOfBrokers) {
    const tests::TemporaryFolder folder;
    const std::string to = folder / "cost";
    const Ran ran = run_romano("cost --brokers 2,4 --seconds 1 --output " + to);
    EXPECT_EQ(ran.exit_code, 0) << ran.output;
    std::ifstream csv(to + "/cost.csv");
    const std::string text{std::istreambuf_iterator<char>(csv), {}};
    const auto rows = parse_csv(text);
    ASSERT_EQ(rows.size(), 3U);
    const auto number = [&](std::size_t row, std::string_view column) {
        const auto at = std::ranges::find(rows[0], column) - rows[0].begin();
        return parse_csv_number(rows[row].at(static_cast<std::size_t>(at))).value();
    };
    EXPECT_EQ(number(1, "brokers"), 2);
    EXPECT_EQ(number(2, "brokers"), 4);
    EXPECT_GT(number(1, "received_octets_per_s"), number(1, "received_beacon_octets_per_s"));
    EXPECT_GT(number(2, "received_octets_per_s"), 2 * number(1, "received_octets_per_s"));
    EXPECT_GT(number(1, "core_share"), 0);
    EXPECT_GT(std::filesystem::file_size(to + "/cost.svg"), 1000U);
}

TEST(Cost, SaysHowFarItIsWhenNobodyWatchesATerminal) {
    const Ran ran = run_romano("cost --brokers 2,3 --robots 0 --seconds 0.1");
    EXPECT_EQ(ran.exit_code, 0) << ran.output;
    EXPECT_THAT(ran.output, HasSubstr("[1/2] 2 brokers: "));
    EXPECT_THAT(ran.output, HasSubstr("[2/2] 3 brokers: "));
}

struct Refused {
    const char* arguments;
    const char* sentence;
};
class RefusedCalls : public ::testing::TestWithParam<Refused> {};

TEST_P(RefusedCalls, SayOneSentenceAndExitWith2) {
    const Ran ran = run_romano(GetParam().arguments);
    EXPECT_EQ(ran.exit_code, 2);
    EXPECT_THAT(ran.output, HasSubstr(GetParam().sentence));
    EXPECT_EQ(std::count(ran.output.begin(), ran.output.end(), '\n'), 1) << ran.output;
}

INSTANTIATE_TEST_SUITE_P(
    Cli, RefusedCalls,
    ::testing::Values(
        Refused{"pub -t a", "one message is needed: -m TEXT, -f FILE, -n (empty) or -l (lines)"},
        Refused{"pub -m a", "a topic is needed: either -t NAME or --predefined ID"},
        Refused{"pub -t a -m b -q 3", "--qos: Value 3 not in range -1 to 2"},
        Refused{"web --ask nan", "--ask: Value nan not in range 0 to 3600"},
        Refused{"web --topics '#/x'", "--topics `#/x`: must be a topic filter"},
        Refused{"replay x.mcap --speed nan", "--speed: Value nan not in range 0.1 to 100"},
        Refused{"pub -t a -m b -p 0", "--port: Value 0 not in range 1 to 65535"},
        Refused{"pub -t abc -m b -q -1", "-q -1 needs a topic without registration"},
        Refused{"pub -t abc --short -m b", "`abc`: a short topic name has two octets"},
        Refused{"pub -t a -m b -h 127.50.250.9 -p 9 --broker-timeout 0.2",
                "no broker serves at 127.50.250.9 port 9: nobody listens there"},
        Refused{"pub -t a -m b --repeat 0", "--repeat: Value 0 not in range 1 to 1000000000"},
        // Nobody is asked whether a broker is there: what is wrong is wrong everywhere.
        Refused{"pub -t a/# -m b -h 127.50.250.9 -p 9", "-t `a/#`: must be a topic's name"},
        Refused{"pub -t a -f /nowhere -h 127.50.250.9 -p 9", "-f `/nowhere`: cannot be read"},
        Refused{"sub -t a -t a/#/b -h 127.50.250.9 -p 9", "-t `a/#/b`: must be UTF-8"},
        Refused{"control 00000001 00000002 --period-ms 300 -h 127.50.250.9 -p 9",
                "--deadline-ms 200: must be more than --period-ms, which is 300"},
        Refused{"control 00000001 --deadline-ms 700 -h 127.50.250.9 -p 9", "20, and 640 at most"},
        Refused{"sub -t a --key /nowhere", "--key: /nowhere: cannot be read"},
        Refused{"control 00000001 --detach --end", "--detach excludes --end"},
        Refused{"move abcd1234 sideways 1m -h 127.50.250.9 -p 9", "movement `sideways`: must be"},
        Refused{"move abcd1234 front 3 -h 127.50.250.9 -p 9", "amount `3`: must be a distance"},
        Refused{"move '' front 1m -h 127.50.250.9 -p 9", "robot ``: must be a topic's name"},
        Refused{"request abcd1234 a/+ location -h 127.50.250.9 -p 9", "topic `a/+`: must be"},
        Refused{"sub", "a topic is needed: -t FILTER or --predefined ID"},
        Refused{"sub -t a -c", "-c needs -i ID"},
        Refused{"sub -t a -W 0.5 -h 127.50.250.9 -p 9",
                "no broker serves at 127.50.250.9 port 9: nobody listens there"},
        Refused{"brokers -h 127.50.250.9 -p 9 --broker-timeout 0.2", "no broker serves at"},
        Refused{"sub -t a -h 'no such host'", "cannot find the host `no such host`"},
        Refused{"sweep /nowhere.toml", "cannot read the sweep file `/nowhere.toml`: no such file"},
        Refused{"simulate --seeds 9..1", "'9..1' is not FIRST..LAST, such as 1..100"},
        Refused{"simulate --acks many", "'many' is not 0 to 99 or all"},
        Refused{"cost --output /proc/none", "cannot write into --output `/proc/none`"},
        Refused{"cost --brokers 0", "--brokers: Value 0 not in range 1 to 100"},
        Refused{"simulate --profile air", "--profile: air not in {lan,wifi,mesh}"},
        Refused{"simulate --fault fire", "--fault: fire not in {crash,stop,leave"},
        Refused{"compare /nowhere /nowhere", "`/nowhere` holds no results of a sweep"},
        Refused{"report /nowhere", "`/nowhere` holds no results of a sweep"},
        Refused{"merge /tmp/x /nowhere", "`/nowhere` holds no results of a sweep"},
        Refused{"sweep x --shard 3/2", "--shard `3/2`: must be I/N with I from 1 to N"},
        Refused{"swep", "The following argument was not expected: swep"},
        Refused{"", "a subcommand is needed: pub, sub, brokers, status"},
        Refused{"status 127.50.250.9", "`127.50.250.9`: write HOST:PORT"},
        Refused{"status 127.50.250.9:9", "no metrics at http://127.50.250.9:9/metrics: "}));

}  // namespace
}  // namespace romano::experiments::cli_test
