// A testbed of three machines, each with a real sshd in a network namespace of its own, and the
// experimenter's machine beside them. Needs root. ROMANO_TESTBED_USER=NAME logs in as a user of
// this machine who may use sudo without a password, instead of root.

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <signal.h>
#include <sys/socket.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "experiments/process/lan.h"
#include "experiments/process/process_file.h"
#include "experiments/process/program.h"
#include "experiments/sweep/results_folder.h"
#include "tests/experiments/system/processes.h"
#include "tests/temporary_folder.h"

namespace romano::experiments::testbed_test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr int machines = 3;
constexpr int experimenter = 4;

std::string read(const fs::path& file) {
    std::ifstream stream(file);
    return {std::istreambuf_iterator<char>(stream), {}};
}

bool eventually(const std::function<bool()>& done) {
    const auto end = std::chrono::steady_clock::now() + 60s;
    while (!done()) {
        if (std::chrono::steady_clock::now() > end) return false;
        std::this_thread::sleep_for(50ms);
    }
    return true;
}

class TestbedOfThree : public ::testing::Test {
protected:
    void SetUp() override {
        if (!lan_.why_not().empty()) GTEST_SKIP() << lan_.why_not();
        fs::create_directories("/run/sshd");
        for (const char* key : {"host_key", "user_key"}) {
            ASSERT_TRUE(run_program("ssh-keygen", {"-q", "-t", "ed25519", "-N", "", "-f",
                                                   (folder_ / key).string()})
                            .ok());
        }
        fs::permissions(folder_.path(), fs::perms{0755});  // the user's sshd reads the key there
        std::ofstream(folder_ / "sshd_config")
            << "HostKey " << (folder_ / "host_key").string() << "\nAuthorizedKeysFile "
            << (folder_ / "user_key.pub").string()
            << "\nStrictModes no\nUsePAM no\nPermitRootLogin prohibit-password\nPidFile none\n"
            // The shell of a user who is slow to greet would be most of this test's time.
            << "Subsystem sftp internal-sftp\nSetEnv SHLVL=2\n"
            // Its network goes with the test, and nobody would tell a session that its client has.
            << "ClientAliveInterval 2\nClientAliveCountMax 3\n";
        for (int machine = 1; machine <= machines; ++machine) {
            ASSERT_NO_FATAL_FAILURE(start_sshd(machine));
        }
        write_hosts();
        give_programs(1);
        give_programs(2);
        give_programs(3);
    }
    void TearDown() override {
        if (!lan_.why_not().empty()) return;
        EXPECT_THAT(programs_left(), IsEmpty()) << "every process of a testbed ends";
    }

    void start_sshd(int machine) {
        const Lan::On there(lan_, machine);
        sshd_[machine - 1] = std::make_unique<BrokerProcess>(
            "sshd", "/usr/sbin/sshd",
            std::vector<std::string>{"-D", "-e", "-f", (folder_ / "sshd_config").string()},
            said_by_sshd(machine));
        ASSERT_TRUE(eventually([&] {
            return read(said_by_sshd(machine)).find("Server listening") != std::string::npos;
        })) << read(said_by_sshd(machine));
    }
    [[nodiscard]] fs::path said_by_sshd(int machine) const {
        return folder_ / ("sshd" + std::to_string(machine) + ".txt");
    }
    [[nodiscard]] std::string folder_of(int machine) const {
        return (folder_ / ("pi" + std::to_string(machine))).string();
    }
    /// As if they were installed; the machines share this file system.
    void give_programs(int machine) const {
        fs::create_directories(folder_of(machine));
        fs::create_symlink(fs::path{BROKER_PROGRAM}.parent_path() / "romano-host",
                           fs::path{folder_of(machine)} / "romano-host");
    }
    static std::string address_of(int machine) { return "10.60.0.10" + std::to_string(machine); }
    static std::string user() {
        const char* name = std::getenv("ROMANO_TESTBED_USER");
        return name == nullptr ? "root" : name;
    }
    void write_hosts(const std::string& first_interface = "eth0",
                     const std::string& network = "10.60.0.",
                     const std::string& services = "10") const {
        std::ofstream file(folder_ / "hosts.toml");
        file << "ssh_options = [\"-F\", \"none\", \"-i\", \"" << (folder_ / "user_key").string()
             << "\", \"-o\", \"StrictHostKeyChecking=no\", \"-o\", \"UserKnownHostsFile=/dev/null\""
             << ", \"-o\", \"LogLevel=ERROR\"]\n"
             << "broker_options = [\"--profile\", \"wifi\"]\n";
        for (int machine = 1; machine <= machines; ++machine) {
            file << "[[hosts]]\nname = \"pi" << machine << "\"\nssh = \"" << user() << "@"
                 << network << machine << "\"\nfolder = \"" << folder_of(machine)
                 << "\"\naddresses = [\"" << network << services << machine << "\"]\ninterface = \""
                 << (machine == 1 ? first_interface : "eth0") << "\"\n";
        }
    }
    /// `romano <arguments>` on the experimenter's machine.
    [[nodiscard]] Ran romano(const std::string& arguments) const {
        const Lan::On here(lan_, experimenter);
        return run_romano(arguments);
    }
    [[nodiscard]] Ran testbed(const std::string& what, const std::string& more = "") const {
        return romano("testbed " + what + " " + (folder_ / "hosts.toml").string() + " " + more);
    }
    void ip(int machine, const std::vector<std::string>& words) const {
        const Lan::On there(lan_, machine);
        ASSERT_TRUE(run_program("ip", words).ok());
    }
    /// All that run, and their command lines; after each word of these stands a zero.
    static std::map<pid_t, std::string> processes() {
        std::map<pid_t, std::string> all;
        for (const auto& entry : fs::directory_iterator("/proc")) {
            const pid_t pid = std::atoi(entry.path().filename().c_str());
            if (pid != 0) all.emplace(pid, process_file(pid, "cmdline"));
        }
        return all;
    }
    /// Of this test's machines, all of which are on this one: "romano-host romano-broker...".
    [[nodiscard]] std::string programs_left() const {
        std::string names;
        for (const auto& [pid, command] : processes()) {
            if (command.find(folder_.path().string()) == std::string::npos) continue;
            if (command.find("romano-host") == std::string::npos) continue;
            std::string line = command;
            std::ranges::replace(line, '\0', ' ');
            names += line + "\n";
        }
        return names;
    }

    /// Its romano-host; 0: none runs.
    [[nodiscard]] pid_t host_process(int machine) const {
        for (const auto& [pid, command] : processes()) {
            if (command.starts_with(folder_of(machine) + "/romano-host")) return pid;
        }
        return 0;
    }
    /// Brokers of a sweep serve all addresses: it has begun in earnest.
    [[nodiscard]] bool is_loading() const {
        for (int machine = 1; machine <= machines; ++machine) {
            if (!lan_.has_address(machine, address_of(machine))) return false;
        }
        return true;
    }

    tests::TemporaryFolder folder_;
    Lan lan_{experimenter};
    std::unique_ptr<BrokerProcess> sshd_[machines];
};

/// `romano-host session` without ssh, told what the shell's words make.
ProgramEnd session(const std::string& words) {
    const std::string host = fs::path{BROKER_PROGRAM}.parent_path() / "romano-host";
    return run_program("/bin/sh", {"-c", words, host});
}

TEST(RomanoHost, AnswersWhateverItIsTold) {
    const ProgramEnd end = session(
        "printf '%s\\n' nonsense '[]' '{}' '{\"do\":7}' '{\"do\":\"dance\"}' "
        "'{\"do\":\"start\",\"order\":{}}' '{\"do\":\"facts\"}' '{\"do\":\"time\"}' | \"$0\" "
        "session");
    EXPECT_EQ(end.exit_code, 0);
    EXPECT_THAT(end.output, HasSubstr("`dance` before `begin`"));
    EXPECT_THAT(end.output, HasSubstr("time_s"));
}

TEST(RomanoHost, KeepsOnlyWhatTheTestbedLeft) {
    const tests::TemporaryFolder folder;
    for (const char* left : {"", "echo '[7]' > $FOLDER/kept.json; "}) {
        const ProgramEnd end =
            session("FOLDER=" + folder.path().string() + "; " + left + "\"$0\" keep $FOLDER 2>&1");
        EXPECT_EQ(end.exit_code, 2);
        EXPECT_THAT(end.output, HasSubstr("kept.json: must be what `romano testbed start` wrote"));
    }
}

// A cable that was pulled tells nobody.
TEST(RomanoHost, EndsWhenNobodySpeaksToItForTenSeconds) {
    const tests::TemporaryFolder folder;
    const std::string pipe = (folder / "pipe").string();
    EXPECT_EQ(
        session("mkfifo " + pipe + "; exec \"$0\" session <>" + pipe + " >/dev/null").exit_code, 0);
}

TEST_F(TestbedOfThree, IsCheckedAndWhatIsWrongIsSaid) {
    const Ran healthy = testbed("check");
    EXPECT_EQ(healthy.exit_code, 0) << healthy.output;
    EXPECT_EQ(healthy.output, "3 hosts are ready\n");

    // A stranger on the port, an address of the machine's own, an MTU that is smaller.
    const int stranger = [this] {
        const Lan::On there(lan_, 1);
        return ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    }();
    sockaddr_in any{};
    any.sin_family = AF_INET;
    any.sin_port = htons(1883);
    ASSERT_EQ(::bind(stranger, reinterpret_cast<const sockaddr*>(&any), sizeof any), 0);
    ip(2, {"address", "add", address_of(2) + "/24", "dev", "eth0"});
    ip(3, {"link", "set", "dev", "eth0", "mtu", "1400"});
    const Ran ill = testbed("check");
    ::close(stranger);
    EXPECT_EQ(ill.exit_code, 1);
    EXPECT_THAT(ill.output, HasSubstr("pi1: the UDP port is in use by testbed_system_"));
    EXPECT_THAT(ill.output, HasSubstr("pi2: address 10.60.0.102 is the machine's own"));
    EXPECT_THAT(ill.output, HasSubstr("pi3: it hears short datagrams of pi1 and none of 1500"));

    // A machine that is off; one whose service address is another's; JSON.
    sshd_[2].reset();
    ip(2, {"address", "del", address_of(2) + "/24", "dev", "eth0"});
    ip(3, {"address", "add", address_of(2) + "/24", "dev", "eth0"});
    const Ran json = testbed("check", "--json");
    EXPECT_EQ(json.exit_code, 1);
    const auto told = nlohmann::json::parse(json.output);
    EXPECT_THAT(told.dump(), HasSubstr("ssh cannot reach it"));
    EXPECT_THAT(told.dump(), HasSubstr("10.60.0.102 is answered by another machine already"));
    EXPECT_EQ(told["hosts"][0]["facts"]["own_addresses"][0], "10.60.0.1");
}

TEST_F(TestbedOfThree, RefusesWhatIsNoHostsFile) {
    const Ran none = romano("testbed check " + (folder_ / "nowhere.toml").string());
    EXPECT_EQ(none.exit_code, 2);
    EXPECT_THAT(none.output, HasSubstr("no such file"));
    write_hosts("eth9");
    const Ran wrong = testbed("check");
    EXPECT_EQ(wrong.exit_code, 1);
    EXPECT_THAT(wrong.output, HasSubstr("pi1: it has no interface `eth9`"));
}

TEST_F(TestbedOfThree, IsInstalledStartedReadAndStopped) {
    fs::remove_all(folder_of(1));
    EXPECT_THAT(testbed("check").output, HasSubstr("pi1: romano-host is not there yet"));
    const Ran installed = testbed("install");
    EXPECT_EQ(installed.exit_code, 0) << installed.output;
    EXPECT_THAT(installed.output, HasSubstr("pi1: has romano-broker "));

    const Ran started = testbed("start");
    ASSERT_EQ(started.exit_code, 0) << started.output;
    EXPECT_TRUE(eventually([this] {
        return romano("brokers -h " + address_of(2)).output.find("pi3") != std::string::npos;
    })) << romano("brokers -h " + address_of(2)).output;
    EXPECT_THAT(testbed("logs", "--host pi2").output,
                HasSubstr("romano-broker pi2: serving 10.60.0.102:1883"));
    EXPECT_THAT(testbed("start").output, HasSubstr("pi1: it is taken by romano testbed start"));
    EXPECT_THAT(testbed("check").output, HasSubstr("pi1: (warning) it is taken by"));

    const Ran stopped = testbed("stop");
    EXPECT_EQ(stopped.exit_code, 0) << stopped.output;
    EXPECT_THAT(stopped.output, HasSubstr("pi3: stopped"));
    for (int machine = 1; machine <= machines; ++machine) {
        for (int of = 1; of <= machines; ++of) {
            EXPECT_FALSE(lan_.has_address(machine, address_of(of)));
        }
    }
    EXPECT_THAT(testbed("stop").output, HasSubstr("pi1: nothing ran"));
}

TEST_F(TestbedOfThree, MayHaveIpv6AddressesAlone) {
    write_hosts("eth0", "fd60::", "10");
    fs::remove_all(folder_of(1));
    const Ran installed = testbed("install");
    EXPECT_EQ(installed.exit_code, 0) << installed.output;
    EXPECT_EQ(testbed("check").output, "3 hosts are ready\n");
    const Ran started = testbed("start");
    ASSERT_EQ(started.exit_code, 0) << started.output;
    EXPECT_TRUE(eventually([this] {
        return romano("brokers -h fd60::102").output.find("pi3") != std::string::npos;
    })) << romano("brokers -h fd60::102").output;
    EXPECT_EQ(testbed("stop").exit_code, 0);
    EXPECT_FALSE(lan_.has_address(2, "fd60::102"));
}

TEST_F(TestbedOfThree, HasRobotsOnMachinesOfTheirOwn) {
    std::string hosts = read(folder_ / "hosts.toml");
    const std::string address = "addresses = [\"" + address_of(3) + "\"]";
    hosts.replace(hosts.find(address), address.size(), "role = \"robots\"\nrobots = 5");
    std::ofstream(folder_ / "hosts.toml") << hosts;
    const Ran started = testbed("start");
    ASSERT_EQ(started.exit_code, 0) << started.output;
    EXPECT_TRUE(eventually([this] {
        return romano("robots -h " + address_of(1)).output.find("5 robots") != std::string::npos;
    })) << romano("robots -h " + address_of(1)).output;
    EXPECT_THAT(testbed("logs", "--host pi3").output, HasSubstr("established"));
    EXPECT_EQ(testbed("stop").exit_code, 0);
}

// Nothing is half-started: a broker that cannot start takes the others with it.
TEST_F(TestbedOfThree, IsStartedWholeOrNotAtAll) {
    std::ofstream(folder_ / "hosts.toml", std::ios::app)
        << "broker_options = [\"--elector\", \"moon\"]\n";
    const Ran started = testbed("start");
    EXPECT_EQ(started.exit_code, 1);
    EXPECT_THAT(started.output, AllOf(HasSubstr("pi3: "), HasSubstr("moon")));
    EXPECT_THAT(testbed("stop").output, HasSubstr("pi1: nothing ran"));
}

/// The experimenter's `romano`, in the background.
class Sweep : public TestbedOfThree {
protected:
    void write_sweep(const std::string& axes) const {
        std::ofstream(folder_ / "small.toml")
            << "duration = 3\nfault_after = 0.5\npause = 1\nretry = 0.3\nstart_within = 60\n"
            << "drain = 20\npublish_within = 30\nport = 1900\noutput = \""
            << (folder_ / "out").string() << "\"\n"
            << axes;
    }
    [[nodiscard]] std::string arguments() const {
        return "sweep " + (folder_ / "small.toml").string() + " --hosts " +
               (folder_ / "hosts.toml").string();
    }
    [[nodiscard]] Ran sweep(const std::string& more = "") const {
        return romano(arguments() + " " + more);
    }
    [[nodiscard]] std::unique_ptr<BrokerProcess> begin_sweep() const {
        const Lan::On here(lan_, experimenter);
        return std::make_unique<BrokerProcess>(
            "sweep", ROMANO_PROGRAM,
            std::vector<std::string>{"sweep", (folder_ / "small.toml").string(), "--hosts",
                                     (folder_ / "hosts.toml").string()},
            folder_ / "sweep.txt");
    }
    [[nodiscard]] fs::path out() const { return folder_ / "out-on-hosts"; }
    [[nodiscard]] std::vector<RunRow> rows() const {
        return fs::exists(out() / "runs.csv") ? read_results(out()).rows : std::vector<RunRow>{};
    }
    [[nodiscard]] bool has_any_service_address() const {
        for (int machine = 1; machine <= machines; ++machine) {
            for (int of = 1; of <= machines; ++of) {
                if (lan_.has_address(machine, address_of(of))) return true;
            }
        }
        return false;
    }
};

TEST_F(Sweep, RunsBrokersThereAndFetchesWhatTheySaid) {
    write_sweep(
        "[[axes]]\nbrokers = 1\nrobots = 4\nrate = 10\n"
        "[[axes]]\nbrokers = 3\nrobots = 6\nrate = 10\nfault = [\"cut\", \"rolling-kill\"]\n");
    const Ran ran = sweep();
    ASSERT_THAT(rows(), SizeIs(3)) << ran.output;
    for (const RunRow& row : rows()) {
        EXPECT_EQ(row.status, "ok") << ran.output;
        EXPECT_GT(row.delivered, 0);
        EXPECT_GT(row.broker_rss_peak_mib_mean, 1);
    }
    EXPECT_EQ(rows()[0].delivery_ratio, 1);
    EXPECT_EQ(rows()[1].strikes, 1);
    EXPECT_GT(rows()[2].strikes, 0);
    const std::string trace = read(out() / "traces/cell-0001-b1.txt");
    EXPECT_THAT(trace, HasSubstr("serving 10.60.0.101:1900"));
    EXPECT_THAT(read(out() / "traces/cell-0001-b1-metrics.txt"), HasSubstr("romano_"));
    EXPECT_THAT(read(out() / "traces/cell-0002-b3.txt"), HasSubstr("serving 10.60.0.103:1900"));
    EXPECT_THAT(read(out() / "hosts.json"), HasSubstr("10.60.0.1"));
    const std::string report = read(out() / "report.html");
    for (const char* part : {"real brokers on 3 hosts", "10.60.0.103", "--hosts "}) {
        EXPECT_THAT(report, HasSubstr(part));
    }
    EXPECT_FALSE(has_any_service_address());

    // One hosts file is one result.
    std::ofstream(folder_ / "hosts.toml", std::ios::app) << "# moved\n";
    const Ran other = sweep();
    EXPECT_EQ(other.exit_code, 2);
    EXPECT_THAT(other.output, HasSubstr("has results of another hosts file"));
}

TEST_F(Sweep, GoesOnWithoutAMachineThatVanishedAndRunsItsCellAgainLater) {
    write_sweep("[axes]\nbrokers = [3, 1]\nrobots = 4\nrate = 10\n");
    const auto running = begin_sweep();
    ASSERT_TRUE(eventually([this] { return host_process(3) != 0 && is_loading(); }))
        << read(folder_ / "sweep.txt");
    ::kill(host_process(3), SIGKILL);
    ASSERT_TRUE(eventually([&] { return running->has_ended(); }));
    ASSERT_THAT(rows(), SizeIs(2)) << read(folder_ / "sweep.txt");
    EXPECT_THAT(rows()[0].status, HasSubstr("pi3 vanished: its ssh connection ended"));
    EXPECT_EQ(rows()[1].status, "ok") << "it needs pi1 alone";
    // What was killed with kill -9 leaves its address to the kernel, for some seconds.
    EXPECT_TRUE(eventually([this] { return !has_any_service_address(); }));

    const Ran again = sweep("--retry-failed");
    ASSERT_THAT(rows(), SizeIs(2));
    EXPECT_EQ(rows()[0].status, "ok") << again.output;
}

// No connection ends when a cable is pulled: either side must notice the silence.
TEST_F(Sweep, GoesOnWithoutAMachineWhoseCableIsPulled) {
    write_sweep("[axes]\nbrokers = [3, 1]\nrobots = 4\nrate = 10\n");
    const auto running = begin_sweep();
    ASSERT_TRUE(eventually([this] { return is_loading(); })) << read(folder_ / "sweep.txt");
    lan_.cut(3);
    ASSERT_TRUE(eventually([&] { return running->has_ended(); }));
    ASSERT_THAT(rows(), SizeIs(2)) << read(folder_ / "sweep.txt");
    EXPECT_THAT(rows()[0].status, HasSubstr("pi3 vanished"));
    EXPECT_EQ(rows()[1].status, "ok") << "it needs pi1 alone";
    EXPECT_TRUE(eventually([this] { return programs_left().empty(); })) << programs_left();
    EXPECT_FALSE(has_any_service_address()) << "pi3, which nobody could tell, has cleaned up too";

    lan_.mend(3);
    const Ran again = sweep("--retry-failed");
    ASSERT_THAT(rows(), SizeIs(2));
    EXPECT_EQ(rows()[0].status, "ok") << again.output;
}

// Nobody is left to clean up: the machines do it themselves.
TEST_F(Sweep, LeavesNothingBehindWhenItIsKilled) {
    write_sweep("[axes]\nbrokers = 3\nrobots = 4\nrate = 10\n");
    const auto killed = begin_sweep();
    ASSERT_TRUE(eventually([this] { return is_loading(); })) << read(folder_ / "sweep.txt");
    killed->kill();
    EXPECT_TRUE(eventually([this] { return programs_left().empty(); })) << programs_left();
    EXPECT_FALSE(has_any_service_address());
}

TEST_F(Sweep, StopsItsBrokersAtCtrlC) {
    write_sweep("[axes]\nbrokers = 3\nrobots = 4\nrate = 10\n");
    const auto interrupted = begin_sweep();
    ASSERT_TRUE(eventually([this] { return is_loading(); })) << read(folder_ / "sweep.txt");
    ::kill(interrupted->pid(), SIGINT);
    ASSERT_TRUE(eventually([&] { return interrupted->has_ended(); }));
    EXPECT_THAT(interrupted->how_it_ended(), HasSubstr("exit code 130"));
    EXPECT_THAT(programs_left(), IsEmpty());
    EXPECT_FALSE(has_any_service_address());
    EXPECT_THAT(rows(), IsEmpty());
}

TEST_F(Sweep, IsRefusedBeforeAnythingRunsWhenTheHostsAreNotReady) {
    write_sweep("[axes]\nbrokers = [1, 4]\n");
    const Ran many = sweep();
    EXPECT_EQ(many.exit_code, 2);
    EXPECT_THAT(many.output, HasSubstr("cells of 4 brokers, and the hosts file has 3 addresses"));
    sshd_[1].reset();
    const Ran off = sweep();
    EXPECT_EQ(off.exit_code, 2);
    EXPECT_THAT(off.output, HasSubstr("pi2: ssh cannot reach it"));
    EXPECT_FALSE(fs::exists(out()));
}

}  // namespace
}  // namespace romano::experiments::testbed_test
