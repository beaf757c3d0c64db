// What a sweep file may say, which cells come of it, and the sentence for everything else.

#include "experiments/sweep/sweep_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

namespace romano::experiments::sweep_file_test {
namespace {

using ::testing::HasSubstr;
using ::testing::SizeIs;

std::string refusal_of(std::string_view text) {
    try {
        (void)parse_sweep(text, "try.toml");
    } catch (const SweepError& error) {
        return error.what();
    }
    return "accepted";
}

TEST(SweepFile, NeedsNoMoreThanAxes) {
    const Sweep sweep = parse_sweep("[axes]\n", "folder/small.toml");
    EXPECT_EQ(sweep.settings.name, "small");
    EXPECT_EQ(sweep.settings.output, "results/small");
    ASSERT_THAT(sweep.cells, SizeIs(1));
    EXPECT_EQ(sweep.cells[0].payload_octets, 32u);
}

TEST(SweepFile, ReadsEverySetting) {
    const Sweep sweep = parse_sweep(R"(
        name = "all"
        pattern = "common"
        repetitions = 2
        duration = 7
        fault_after = 2.5
        pause = 1
        drain = 3
        start_within = 9
        retry = 0.5
        publish_within = 0.1
        probe = 200
        group = 4
        domain_base = 100
        network = "127.50"
        port = 1884
        output = "somewhere/else"
        [axes]
        brokers = 3
        robots = [5, 10]
        rate = 2.5
        payload = 64
        qos = [1, "0+1+2"]
        acks = [0, "all"]
        clients = "dtls"
        fault = "pause"
        seed = 42
    )",
                                    "try.toml");
    EXPECT_EQ(sweep.settings.pattern, Pattern::common);
    EXPECT_EQ(sweep.settings.duration.count(), 7);
    EXPECT_EQ(sweep.settings.port, 1884);
    EXPECT_EQ(sweep.settings.output, "somewhere/else");
    ASSERT_THAT(sweep.cells, SizeIs(16));
    const Cell& last = sweep.cells.back();
    EXPECT_EQ(last.number, 16u);
    EXPECT_EQ(last.robots, 10u);
    EXPECT_EQ(last.qos.text(), "0+1+2");
    EXPECT_EQ(last.acks, "all");
    EXPECT_EQ(last.clients, "dtls");
    EXPECT_EQ(last.fault, Fault::pause);
    EXPECT_EQ(last.seed, 42u);
    EXPECT_EQ(last.repetition, 2u);
}

TEST(SweepFile, ReadsTheLinksOfASimulatedWorld) {
    const Sweep sweep = parse_sweep(R"(
        world = "simulated"
        client_delay_ms = 5
        client_loss_percent = 1.5
        wire_delay_ms = [1, 2.5]
        wifi_loss_percent = 3
        [axes]
        brokers = [1, 100]
        robots = 2000
    )",
                                    "try.toml");
    EXPECT_EQ(sweep.settings.world, World::simulated);
    EXPECT_EQ(sweep.settings.client_link,
              (SimulatedLink{.delay_min_ms = 5, .delay_max_ms = 5, .loss_percent = 1.5}));
    EXPECT_EQ(sweep.settings.wire,
              (SimulatedLink{.delay_min_ms = 1, .delay_max_ms = 2.5, .loss_percent = 0}));
    EXPECT_EQ(sweep.settings.wifi,
              (SimulatedLink{.delay_min_ms = 1, .delay_max_ms = 5, .loss_percent = 3}));
    EXPECT_THAT(sweep.cells, SizeIs(2));
}

TEST(SweepFile, HasTheLinesAndTheBackboneOfARadioWorldAsAxes) {
    const Sweep sweep = parse_sweep(R"(
        world = "radio"
        [axes]
        brokers = [1, 2]
        backbone = ["wire", "wifi", "radio"]
        router_baud = [115200, "none"]
        robot_baud = 230400
    )",
                                    "try.toml");
    ASSERT_THAT(sweep.cells, SizeIs(8)) << "one broker has no backbone";
    EXPECT_EQ(sweep.cells[0].backbone, "");
    EXPECT_EQ(sweep.cells[0].router_baud, "115200");
    EXPECT_EQ(sweep.cells[1].router_baud, "none");
    EXPECT_EQ(sweep.cells[1].robot_baud, "230400");
    EXPECT_EQ(sweep.cells[7].backbone, "radio");
    EXPECT_THAT(describe(sweep.cells[7]),
                HasSubstr("backbone radio, routers without UART, robots 230400 baud"));
}

TEST(SweepFile, HasNoLinesWhereTheWorldHasNone) {
    const Cell real = parse_sweep("[axes]\nbrokers = 2", "try.toml").cells[0];
    EXPECT_EQ(real.backbone, "wire") << "this machine's network";
    EXPECT_EQ(real.router_baud + real.robot_baud, "");
    const Cell simulated =
        parse_sweep("world = \"simulated\"\n[axes]\nbrokers = 2", "try.toml").cells[0];
    EXPECT_EQ(simulated.backbone, "wire");
    EXPECT_EQ(simulated.router_baud + simulated.robot_baud, "");
}

// A row of the one is none of the other.
TEST(SweepFile, MeansAnotherExperimentInAnotherWorld) {
    EXPECT_FALSE(is_same_experiment(parse_sweep("[axes]", "try.toml"),
                                    parse_sweep("world = \"simulated\"\n[axes]", "try.toml")));
}

TEST(Cells, AreAllCombinationsRepetitionsOutermost) {
    const Sweep sweep =
        parse_sweep("repetitions = 2\n[axes]\nbrokers = [2, 3]\nrobots = [5, 6]\n", "try.toml");
    ASSERT_THAT(sweep.cells, SizeIs(8));
    for (std::size_t i = 0; i < 8; ++i) {
        EXPECT_EQ(sweep.cells[i].number, i + 1);
        EXPECT_EQ(sweep.cells[i].repetition, i / 4 + 1);
        EXPECT_EQ(sweep.cells[i].robots, i / 2 % 2 == 0 ? 5u : 6u);
        EXPECT_EQ(sweep.cells[i].brokers, i % 2 == 0 ? 2u : 3u);
    }
}

TEST(Cells, OfOneBrokerHaveNoFaultAndNothingOfACluster) {
    const Sweep sweep = parse_sweep(
        "[axes]\nbrokers = [1, 2]\nacks = [0, 1]\nfault = [\"none\", \"kill-leader\"]\n",
        "try.toml");
    ASSERT_THAT(sweep.cells, SizeIs(5));
    EXPECT_EQ(sweep.cells[0].brokers, 1u);
    EXPECT_EQ(sweep.cells[0].acks, "");
    EXPECT_EQ(sweep.cells[1].brokers, 2u);
    EXPECT_THAT(refusal_of("[axes]\nbrokers = 1\nfault = \"pause\"\n"),
                HasSubstr("a fault needs at least 2 brokers"));
}

TEST(Cells, OfSeveralTablesAreTheirUnion) {
    const Sweep sweep =
        parse_sweep("[[axes]]\nbrokers = [1, 2]\n[[axes]]\nbrokers = [2, 3]\n", "try.toml");
    ASSERT_THAT(sweep.cells, SizeIs(3));
    EXPECT_EQ(sweep.cells[2].brokers, 3u);
}

TEST(QosMixes, GiveEachMessageItsLevelInTurn) {
    const auto mix = parse_qos_mix("0+1+1+2");
    ASSERT_TRUE(mix);
    std::string levels;
    for (std::uint32_t i = 0; i < 8; ++i) levels += std::to_string(mix->level(i));
    EXPECT_EQ(levels, "01120112");
    for (const char* wrong : {"", "3", "0+", "+1", "0,1", "0++1", "-1"}) {
        EXPECT_FALSE(parse_qos_mix(wrong)) << wrong;
    }
}

struct Refusal {
    const char* text;
    const char* sentence;
};

class Refusals : public ::testing::TestWithParam<Refusal> {};

TEST_P(Refusals, NameSettingValueAndWhatIsAllowed) {
    EXPECT_EQ(refusal_of(GetParam().text), GetParam().sentence);
}

INSTANTIATE_TEST_SUITE_P(
    SweepFile, Refusals,
    ::testing::Values(
        Refusal{"durations = 3\n[axes]",
                "try.toml, line 1: unknown setting `durations`; known are name, world, "
                "pattern, repetitions, duration, fault_after, pause, drain, start_within, retry, "
                "publish_within, probe, broker_options, group, client_delay_ms, "
                "client_loss_percent, wire_delay_ms, wire_loss_percent, wifi_delay_ms, "
                "wifi_loss_percent, radio_channels, router_distance_m, domain_base, network, "
                "port, output, axes"},
        Refusal{"brokers = 3\n[axes]",
                "try.toml, line 1: `brokers = 3`: it is an axis, and stands below [axes]"},
        Refusal{"[axes]\nbroker = 3",
                "try.toml, line 2: unknown setting `axes.broker`; known are brokers, robots, "
                "rate, payload, qos, elector, detector, acks, clients, backbone, router_baud, "
                "robot_baud, fault, seed"},
        Refusal{"[axes]\nbrokers = [1, 0]",
                "try.toml, line 2: `axes.brokers = 0`: a whole number from 1 to 32 is allowed"},
        Refusal{"[axes]\nbrokers = \"two\"",
                "try.toml, line 2: `axes.brokers = \"two\"`: a whole number from 1 to 32 is "
                "allowed"},
        Refusal{"[axes]\nbrokers = []",
                "try.toml, line 2: `axes.brokers = []`: at least one value is needed"},
        Refusal{"[axes]\nbrokers = [2, 2]",
                "try.toml, line 2: `axes.brokers = [ 2, 2 ]`: a value may stand there once"},
        Refusal{"[axes]\nfault = \"kill\"",
                "try.toml, line 2: `axes.fault = \"kill\"`: allowed are none, kill-leader, "
                "kill-home, pause, pause-leader, cut, all-but-one, rolling-restart, rolling-kill"},
        Refusal{"[axes]\nqos = 3",
                "try.toml, line 2: `axes.qos = 3`: allowed are 0, 1, 2 or a mix such as "
                "\"0+1+2\""},
        Refusal{"[axes]\npayload = 8",
                "try.toml, line 2: `axes.payload = 8`: a whole number from 16 to 1400 is allowed"},
        Refusal{"[axes]\nrate = 0",
                "try.toml, line 2: `axes.rate = 0`: messages per second from 0.01 to 100000 are "
                "allowed"},
        Refusal{"[axes]\nacks = \"some\"",
                "try.toml, line 2: `axes.acks = \"some\"`: a number of peers from 0 to 31, or "
                "\"all\""},
        Refusal{"[axes]\nclients = \"tls\"",
                "try.toml, line 2: `axes.clients = \"tls\"`: allowed are plain, protected, dtls"},
        Refusal{"world = \"simulated\"\n[axes]\nclients = \"protected\"",
                "try.toml, line 3: `axes.clients = \"protected\"`: allowed are plain"},
        Refusal{"duration = \"long\"\n[axes]",
                "try.toml, line 1: `duration = \"long\"`: seconds from 0 to 86400 are allowed"},
        Refusal{"pattern = \"mesh\"\n[axes]",
                "try.toml, line 1: `pattern = \"mesh\"`: allowed are swarm, common, commands"},
        Refusal{"world = \"moon\"\n[axes]",
                "try.toml, line 1: `world = \"moon\"`: allowed are processes, simulated, "
                "radio, air"},
        Refusal{"world = \"simulated\"\n[axes]\nrouter_baud = 115200",
                "try.toml, line 3: `axes.router_baud = 115200`: only a world on radio "
                "(`world = \"radio\"` or \"air\") has it"},
        Refusal{"world = \"radio\"\n[axes]\nrouter_baud = [115200, 0]",
                "try.toml, line 3: `axes.router_baud = 0`: a baud from 1200 to 10000000 or "
                "\"none\" is allowed"},
        Refusal{"world = \"radio\"\n[axes]\nrobot_baud = \"slow\"",
                "try.toml, line 3: `axes.robot_baud = \"slow\"`: a baud from 1200 to 10000000 or "
                "\"none\" is allowed"},
        Refusal{"world = \"radio\"\n[axes]\nbackbone = \"string\"",
                "try.toml, line 3: `axes.backbone = \"string\"`: allowed are wire, wifi, radio"},
        Refusal{"world = \"simulated\"\n[axes]\nbackbone = \"radio\"",
                "try.toml, line 3: `axes.backbone = \"radio\"`: allowed are wire, wifi"},
        Refusal{"[axes]\nbackbone = \"wifi\"",
                "try.toml, line 2: `axes.backbone = \"wifi\"`: allowed are wire"},
        Refusal{"world = \"radio\"\nradio_channels = 17\n[axes]",
                "try.toml, line 2: `radio_channels = 17`: a whole number from 1 to 16 is allowed"},
        Refusal{"world = \"radio\"\n[axes]\npayload = 1001",
                "try.toml, line 3: `axes.payload = 1001`: a whole number from 16 to 1000 is "
                "allowed"},
        Refusal{"world = \"radio\"\nport = 1884\n[axes]",
                "try.toml, line 2: `port = 1884`: a simulated world has no addresses on this "
                "machine"},
        Refusal{"client_loss_percent = 1\n[axes]",
                "try.toml, line 1: `client_loss_percent = 1`: only a simulated world (`world "
                "= \"simulated\"` or \"radio\") has it"},
        Refusal{"world = \"simulated\"\nport = 1884\n[axes]",
                "try.toml, line 2: `port = 1884`: a simulated world has no addresses on this "
                "machine"},
        Refusal{"world = \"simulated\"\nwire_delay_ms = [3, 1]\n[axes]",
                "try.toml, line 2: `wire_delay_ms = 1`: milliseconds from 0 to 10000 are "
                "allowed, or the least and the most: [1, 5]"},
        Refusal{"world = \"simulated\"\nclient_loss_percent = 51\n[axes]",
                "try.toml, line 2: `client_loss_percent = 51`: percent from 0 to 50 are allowed"},
        Refusal{"world = \"simulated\"\n[axes]\nbrokers = 101",
                "try.toml, line 3: `axes.brokers = 101`: a whole number from 1 to 100 is allowed"},
        Refusal{"world = \"simulated\"\n[axes]\nrobots = 2001",
                "try.toml, line 3: `axes.robots = 2001`: a whole number from 1 to 2000 is allowed"},
        Refusal{"network = \"10.0\"\n[axes]",
                "try.toml, line 1: `network = \"10.0\"`: the first two octets of a loopback "
                "network, 127.0 to 127.255, are allowed"},
        Refusal{"broker_options = \"--realtime\"\n[axes]",
                "try.toml, line 1: `broker_options = \"--realtime\"`: a list of texts is allowed"},
        Refusal{"broker_options = [\"--realtime\", \"--acks=2\"]\n[axes]",
                "try.toml, line 1: `broker_options = [ '--realtime', '--acks=2' ]`: the sweep "
                "itself sets --acks of each broker, as it does all of --name, --listen, --domain, "
                "--interface, --elector, --detector, --acks, --voters"},
        Refusal{"duration = 9\n[axes]\nbrokers = 5\nfault = \"all-but-one\"",
                "try.toml: all but one of 5 brokers are killed after fault_after and so many times "
                "pause (10 s): duration (9 s) must be longer"},
        Refusal{"duration = 3\n[axes]\nbrokers = 2\nfault = \"pause\"",
                "try.toml: fault_after (4 s) must be less than duration (3 s)"},
        Refusal{"name = \"x\"",
                "try.toml: no [axes]; at least `[axes]` with `brokers = [1]` is needed"},
        Refusal{"axes = 3",
                "try.toml, line 1: `axes = 3`: a table [axes], or several [[axes]], are allowed"}));

TEST(SweepFile, KnowsTheElectorsAndDetectorsThatThereAre) {
    EXPECT_THAT(refusal_of("[axes]\nelector = \"king\""),
                HasSubstr("`axes.elector = \"king\"`: allowed are component"));
    EXPECT_THAT(refusal_of("[axes]\ndetector = \"crystal ball\""),
                HasSubstr("`axes.detector = \"crystal ball\"`: allowed are fixed"));
}

TEST(SweepFile, ThatIsNoTomlIsRefusedWithItsLine) {
    EXPECT_THAT(refusal_of("name = \n"), HasSubstr("try.toml, line 1: no TOML: "));
}

TEST(SweepFile, ThatCannotBeReadIsRefusedByName) {
    const auto refusal = [](const char* file) -> std::string {
        try {
            (void)read_sweep(file);
        } catch (const SweepError& error) {
            return error.what();
        }
        return "accepted";
    };
    EXPECT_EQ(refusal("/nowhere/at-all.toml"),
              "cannot read the sweep file `/nowhere/at-all.toml`: no such file");
    EXPECT_EQ(refusal("/tmp"), "cannot read the sweep file `/tmp`: it is a folder");
}

TEST(SweepFiles, OfThisRepositoryAreValid) {
    int files = 0;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(
             std::string{ROMANO_SOURCE_DIR} + "/experiments")) {
        if (entry.path().extension() != ".toml" || entry.path().filename() == "hosts.toml")
            continue;
        ++files;
        EXPECT_NO_THROW((void)read_sweep(entry.path())) << entry.path();
    }
    EXPECT_GT(files, 0);
}

}  // namespace
}  // namespace romano::experiments::sweep_file_test
