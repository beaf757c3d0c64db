#include "broker/daemon/command_line.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "broker/daemon/refusal.h"

namespace romano::daemon::command_line_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

std::variant<SettingTexts, Information> read(std::vector<const char*> arguments) {
    arguments.insert(arguments.begin(), "romano-broker");
    return read_command_line(static_cast<int>(arguments.size()), arguments.data());
}

SettingTexts texts(const std::vector<const char*>& arguments) {
    return std::get<SettingTexts>(read(arguments));
}

std::string refusal(const std::vector<const char*>& arguments) {
    try {
        (void)read(arguments);
    } catch (const Refusal& refused) {
        EXPECT_THAT(refused.what(), testing::Not(HasSubstr("\n"))) << "one sentence is one line";
        return refused.what();
    }
    return "accepted";
}

class ConfigFile {
public:
    explicit ConfigFile(const std::string& text)
        : path_(testing::TempDir() + "romano-config-" + std::to_string(getpid()) + ".toml") {
        std::ofstream(path_) << text;
    }
    ~ConfigFile() { unlink(path_.c_str()); }
    ConfigFile(const ConfigFile&) = delete;
    ConfigFile& operator=(const ConfigFile&) = delete;
    [[nodiscard]] const char* path() const { return path_.c_str(); }

private:
    std::string path_;
};

TEST(CommandLine, TakesRepeatedOptionsAndSeveralValues) {
    const auto read = texts({"--listen", "127.0.0.1:1", "--listen", "[::1]:2", "--predefined",
                             "1=a", "2=b", "--name", "r1"});
    EXPECT_THAT(read.listen, ElementsAre("127.0.0.1:1", "[::1]:2"));
    EXPECT_THAT(read.predefined, ElementsAre("1=a", "2=b"));
    EXPECT_EQ(read.name, "r1");
    EXPECT_FALSE(read.domain);
}

TEST(CommandLine, VotersMayBeRepeated) {
    EXPECT_THAT(texts({"--voters", "r1,r2", "--voters", "r3"}).voters, ElementsAre("r1,r2", "r3"));
    EXPECT_THAT(texts({"--voters", "r1", "r2", "r3"}).voters, ElementsAre("r1", "r2", "r3"));
}

TEST(CommandLine, EveryOptionIsAKeyOfTheConfigurationFile) {
    const ConfigFile file(R"(# a comment
listen = ["127.0.0.1:1883", "[::1]:1883"]
name = "r1"
domain = 7
interface = "lo"
rank = 3
acks = "all"
elector = "component"
voters = ["r1", "r2"]
detector = "fixed"
profile = "wifi"
beacon-ms = 20
detection-timeout-ms = 200
phi-threshold = 9
retry-ms = 500
retries = 7
realtime = true
gateway-id = 9
predefined = ["1=robots/pose", "2=a topic, with comma"]
discovery-group = ["225.1.1.1:1883"]
advertise-period = 60
no-romano = true
log-level = "warn"
)");
    const auto read = texts({"--config", file.path()});
    EXPECT_THAT(read.listen, ElementsAre("127.0.0.1:1883", "[::1]:1883"));
    EXPECT_EQ(read.name, "r1");
    EXPECT_EQ(read.domain, "7");
    EXPECT_EQ(read.interface, "lo");
    EXPECT_EQ(read.rank, "3");
    EXPECT_EQ(read.acks, "all");
    EXPECT_EQ(read.elector, "component");
    EXPECT_THAT(read.voters, ElementsAre("r1", "r2"));
    EXPECT_EQ(read.detector, "fixed");
    EXPECT_EQ(read.profile, "wifi");
    EXPECT_EQ(read.beacon_ms, "20");
    EXPECT_EQ(read.detection_timeout_ms, "200");
    EXPECT_EQ(read.phi_threshold, "9");
    EXPECT_EQ(read.retry_ms, "500");
    EXPECT_EQ(read.retries, "7");
    EXPECT_TRUE(read.realtime);
    EXPECT_EQ(read.gateway_id, "9");
    EXPECT_THAT(read.predefined, ElementsAre("1=robots/pose", "2=a topic, with comma"));
    EXPECT_THAT(read.discovery_group, ElementsAre("225.1.1.1:1883"));
    EXPECT_EQ(read.advertise_period, "60");
    EXPECT_TRUE(read.no_romano);
    EXPECT_EQ(read.log_level, "warn");
}

TEST(CommandLine, GoesBeforeTheConfigurationFile) {
    const ConfigFile file("name = \"from-file\"\nrank = 3\n");
    const auto read = texts({"--config", file.path(), "--name", "from-command-line"});
    EXPECT_EQ(read.name, "from-command-line");
    EXPECT_EQ(read.rank, "3");
}

TEST(CommandLine, RefusesAnUnknownKeyByName) {
    const ConfigFile file("name = \"r1\"\nbananas = 3\n");
    const std::string why = refusal({"--config", file.path()});
    EXPECT_THAT(why, HasSubstr(file.path()));
    EXPECT_THAT(why, HasSubstr("'bananas'"));
}

struct BadFile {
    const char* name;
    const char* text;
    const char* says;
};

class Mistake : public testing::TestWithParam<BadFile> {};

TEST_P(Mistake, IsOneSentenceThatNamesFileLineAndWhatIsAllowed) {
    const ConfigFile file(GetParam().text);
    const std::string why = refusal({"--config", file.path()});
    EXPECT_THAT(why, StartsWith("--config '" + std::string(file.path()) + "': "));
    EXPECT_THAT(why, HasSubstr(GetParam().says));
}

INSTANTIATE_TEST_SUITE_P(
    InTheFile, Mistake,
    testing::Values(
        BadFile{"UnclosedList", "name = \"r1\"\nlisten = [\"127.0.0.1:1883\"\n", "in line "},
        BadFile{"UnclosedText", "name = \"r1\n", "in line 1"},
        BadFile{"NoValue", "name =\n", "in line 1"},
        BadFile{"IniStyle", "name = r1\n", "in line 1"},
        BadFile{"KeyTwice", "rank = 1\nname = \"a\"\nrank = 2\n", "in line 3"},
        BadFile{"UnknownKey", "\nbananas = 3\n", "'bananas' in line 2 is no setting"},
        BadFile{"Section", "[broker]\nname = \"a\"\n", "'broker' in line 1 is no setting"},
        BadFile{"HelpIsNoKey", "help = true\n", "'help' in line 1 is no setting"},
        BadFile{"ConfigIsNoKey", "config = \"b\"\n", "'config' in line 1 is no setting"},
        BadFile{"NumberForText", "name = 3\n", "'name' in line 1 must be a text in quotes"},
        BadFile{"TextForNumber", "rank = \"3\"\n", "'rank' in line 1 must be a whole number"},
        BadFile{"FractionForNumber", "beacon-ms = 1.5\n", "'beacon-ms' in line 1 must be a whole"},
        BadFile{"TextForFraction", "phi-threshold = \"8\"\n",
                "'phi-threshold' in line 1 must be a"},
        BadFile{"TruthForNumber", "rank = true\n", "'rank' in line 1 must be a whole number"},
        BadFile{"TextForFlag", "store-sync = \"no\"\n", "'store-sync' in line 1 must be true or"},
        BadFile{"ListForOne", "name = [\"a\", \"b\"]\n", "'name' in line 1 must be a text"},
        BadFile{"NumberInList", "listen = [\"a\",\n 5]\n", "'listen' in line 2 must be a list of"},
        BadFile{"ListInList", "listen = [[\"a\"]]\n", "'listen' in line 1 must be a list of"}),
    [](const auto& test) { return test.param.name; });

TEST(CommandLine, DefaultConfigReadsBackAsTheDefaults) {
    std::string text = std::get<Information>(read({"--default-config"})).text;
    EXPECT_THAT(text, HasSubstr("# Serve clients at this address"));
    EXPECT_THAT(text, HasSubstr("#max-sessions = 20000\n"));
    EXPECT_THAT(text, HasSubstr("# domain = 0..230\n"));
    std::string uncommented;  // "#key" but not "# words"
    for (std::size_t at = 0; at < text.size(); ++at) {
        const bool at_key = text[at] == '#' && text[at + 1] != ' ' && text[at + 1] != '\n';
        if (!at_key) uncommented += text[at];
    }
    for (const std::string& file_text : {text, uncommented}) {
        const ConfigFile file(file_text);
        const auto from_file = texts({"--config", file.path()});
        EXPECT_EQ(from_file.limits, SettingTexts{}.limits);
        EXPECT_EQ(from_file.rank, SettingTexts{}.rank);
        EXPECT_EQ(from_file.log_level, SettingTexts{}.log_level);
        EXPECT_EQ(from_file.store, std::nullopt);
        EXPECT_FALSE(from_file.store_sync);
        EXPECT_TRUE(from_file.listen.empty());
    }
}

TEST(CommandLine, FlagsAndLimitsAreKeysToo) {
    const ConfigFile file("store = \"/tmp/s.db\"\nstore-sync = true\nmax-queued = 7\n");
    const auto read = texts({"--config", file.path(), "--max-sessions", "9"});
    EXPECT_EQ(read.store, "/tmp/s.db");
    EXPECT_TRUE(read.store_sync);
    EXPECT_EQ(read.limits.at("max-queued"), "7");
    EXPECT_EQ(read.limits.at("max-sessions"), "9");
}

TEST(CommandLine, RefusesAFileThatIsNoConfiguration) {
    const ConfigFile file("\x7f\x45\x4c\x46 this is not toml\n");
    EXPECT_THAT(refusal({"--config", file.path()}), StartsWith("--config '"));
}

TEST(CommandLine, RefusesAFileThatCannotBeRead) {
    EXPECT_THAT(refusal({"--config", "/no/such/file.toml"}), HasSubstr("/no/such/file.toml"));
    EXPECT_THAT(refusal({"--config", "/tmp"}), HasSubstr("'/tmp'"));
}

TEST(CommandLine, RefusesAnUnknownOptionByName) {
    EXPECT_THAT(refusal({"--bananas", "3"}), HasSubstr("--bananas"));
    EXPECT_THAT(refusal({"stray"}), HasSubstr("stray"));
}

TEST(CommandLine, RefusesAnOptionWithoutItsValue) {
    EXPECT_THAT(refusal({"--listen"}), HasSubstr("--listen"));
    EXPECT_THAT(refusal({"--name"}), HasSubstr("--name"));
}

TEST(CommandLine, RefusesTheSameSingleOptionTwice) {
    EXPECT_THAT(refusal({"--name", "a", "--name", "b"}), HasSubstr("--name"));
}

TEST(CommandLine, HelpShowsExamplesAndAllOptions) {
    const auto help = std::get<Information>(read({"--help"})).text;
    EXPECT_THAT(help, HasSubstr("Examples:"));
    for (const char* option : {"--listen",
                               "--name",
                               "--domain",
                               "--interface",
                               "--rank",
                               "--acks",
                               "--elector",
                               "--voters",
                               "--condition-file",
                               "--detector",
                               "--profile",
                               "--beacon-ms",
                               "--detection-timeout-ms",
                               "--phi-threshold",
                               "--retry-ms",
                               "--retries",
                               "--realtime",
                               "--gateway-id",
                               "--predefined",
                               "--discovery-group",
                               "--advertise-period",
                               "--cell-group",
                               "--log-level",
                               "--config",
                               "--version"}) {
        EXPECT_THAT(help, HasSubstr(option));
    }
}

TEST(CommandLine, VersionNamesTheProgram) {
    EXPECT_THAT(std::get<Information>(read({"--version"})).text, StartsWith("romano-broker "));
}

}  // namespace
}  // namespace romano::daemon::command_line_test
