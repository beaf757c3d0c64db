// Processes under control end when told, when killed, and with their owner. /bin/sh stands in for
// a broker.

#include "experiments/process/broker_process.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstring>
#include <fstream>
#include <thread>

#include "experiments/process/process_file.h"
#include "experiments/process/process_usage.h"
#include "tests/temporary_folder.h"

namespace romano::experiments::broker_process_test {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

class BrokerProcesses : public ::testing::Test {
protected:
    std::unique_ptr<BrokerProcess> shell(const std::string& script) {
        return std::make_unique<BrokerProcess>("b1", "/bin/sh",
                                               std::vector<std::string>{"-c", script}, trace_);
    }

    /// Until the process has said something.
    void await_trace() const {
        for (int i = 0; i < 1000 && std::filesystem::file_size(trace_) == 0; ++i) {
            std::this_thread::sleep_for(5ms);
        }
    }
    static void await_end(BrokerProcess& process) {
        for (int i = 0; i < 1000 && !process.has_ended(); ++i) std::this_thread::sleep_for(5ms);
    }

    tests::TemporaryFolder folder_;
    std::filesystem::path trace_ = folder_ / "trace";
};

TEST_F(BrokerProcesses, SayHowTheyEnded) {
    const auto process = shell("echo port 1883 is in use >&2; exit 2");
    await_end(*process);
    EXPECT_EQ(process->how_it_ended(), "exit code 2: port 1883 is in use");
}

TEST_F(BrokerProcesses, AreGoneOnceKilled) {
    const auto process = shell("echo up; exec sleep 60");
    await_trace();
    EXPECT_FALSE(process->has_ended());
    process->kill();
    EXPECT_TRUE(process->has_ended());
    EXPECT_EQ(::kill(process->pid(), 0), -1);
    EXPECT_THAT(process->how_it_ended(), HasSubstr("signal 9"));
}

TEST_F(BrokerProcesses, StopWhenAskedAlsoWhilePaused) {
    const auto process = shell("trap 'exit 0' TERM; echo up; while :; do sleep 0.01; done");
    await_trace();
    process->pause();
    process->stop(5s);
    EXPECT_THAT(process->how_it_ended(), HasSubstr("exit code 0"));
}

TEST_F(BrokerProcesses, AreKilledWhenTheyDoNotStop) {
    const auto process = shell("trap '' TERM; echo up; while :; do sleep 0.01; done");
    await_trace();
    process->stop(50ms);
    EXPECT_THAT(process->how_it_ended(), HasSubstr("signal 9"));
}

TEST_F(BrokerProcesses, DieWithTheirOwner) {
    auto process = shell("echo up; exec sleep 60");
    const pid_t pid = process->pid();
    process.reset();
    EXPECT_EQ(::kill(pid, 0), -1);
}

TEST_F(BrokerProcesses, ThatCannotBeStartedSayWhy) {
    try {
        const BrokerProcess process{"b1", "/nowhere/romano-broker", {}, trace_};
        FAIL() << "started";
    } catch (const std::runtime_error& error) {
        EXPECT_STREQ(error.what(),
                     "cannot start `/nowhere/romano-broker`: No such file or directory");
    }
}

TEST_F(BrokerProcesses, InheritNothingButTheirStreams) {
    const int inheritable = ::dup(STDERR_FILENO);  // without close-on-exec, as from a library
    // The fourth is the folder's own, which `ls` reads.
    const auto process = shell("exec ls -m /proc/self/fd");
    await_end(*process);
    EXPECT_EQ(process->how_it_ended(), "exit code 0: 0, 1, 2, 3");
    ::close(inheritable);
}

TEST_F(BrokerProcesses, AreStartedWithoutACopyOfTheirOwner) {
    constexpr std::size_t pages = 4096;
    const std::size_t octets = pages * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
    void* const memory =
        ::mmap(nullptr, octets, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    ASSERT_NE(memory, MAP_FAILED);
    ::madvise(memory, octets, MADV_NOHUGEPAGE);
    const auto faults_of_writing = [&] {
        const auto faults = [] {
            rusage usage{};
            ::getrusage(RUSAGE_SELF, &usage);
            return static_cast<std::size_t>(usage.ru_minflt);
        };
        const std::size_t before = faults();
        std::memset(memory, 1, octets);
        return faults() - before;
    };
    EXPECT_GE(faults_of_writing(), pages);
    const auto process = shell("echo up; exec sleep 60");
    await_trace();
    EXPECT_LT(faults_of_writing(), pages / 2) << "its pages were shared with the child";
    process->kill();
    ::munmap(memory, octets);
}

TEST(ProcessUsages, AreReadFromTheKernelsText) {
    const auto usage =
        parse_usage("42 (a (strange) name) S 1 42 42 0 -1 4194560 100 0 0 0 150 50 0 0",
                    "Name:\tx\nVmPeak:\t 9999 kB\nVmHWM:\t  2048 kB\nVmRSS:\t  1024 kB\n", 100);
    ASSERT_TRUE(usage);
    EXPECT_DOUBLE_EQ(usage->cpu_s, 2.0);
    EXPECT_DOUBLE_EQ(usage->rss_peak_mib, 2.0);
    EXPECT_FALSE(parse_usage("", "", 100));
}

TEST(ProcessUsages, OfThisProcessAreThere) {
    const auto usage = usage_of(::getpid());
    ASSERT_TRUE(usage);
    EXPECT_GT(usage->rss_peak_mib, 0);
    EXPECT_FALSE(usage_of(-1));
}

// Reading such a file fails then (ESRCH), and that is no error.
TEST_F(BrokerProcesses, SayNothingWhenTheyEndWhileTheyAreRead) {
    const auto process = shell("echo ready; sleep 60");
    await_trace();  // before that it may be about to become the shell, and has no command line
    EXPECT_THAT(process_file(process->pid(), "cmdline"), HasSubstr("sleep 60"));
    std::ifstream opened("/proc/" + std::to_string(process->pid()) + "/cmdline");
    ASSERT_TRUE(opened.is_open());
    process->kill();
    EXPECT_EQ(process_file(opened), "");
    EXPECT_EQ(process_file(process->pid(), "cmdline"), "");
}

}  // namespace
}  // namespace romano::experiments::broker_process_test
