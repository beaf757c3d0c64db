// A sweep on a real Slurm: controller and one node on this machine, with ports of their own.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pwd.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <iterator>
#include <memory>
#include <string>
#include <thread>

#include "experiments/process/process_file.h"
#include "experiments/process/program.h"
#include "experiments/sweep/results_folder.h"
#include "tests/experiments/system/processes.h"
#include "tests/temporary_folder.h"

namespace romano::experiments::slurm_test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using ::testing::HasSubstr;
using ::testing::SizeIs;

class Slurm : public ::testing::Test {
protected:
    void SetUp() override {
        for (const char* part : {"state", "spool"}) fs::create_directory(folder_ / part);
        const std::string in = folder_.path().string() + "/";
        const std::string user = ::getpwuid(::geteuid())->pw_name;
        const int port = 21'000 + ::getpid() % 10'000;
        std::ofstream(folder_ / "slurm.conf")
            << "ClusterName=test\nSlurmctldHost=localhost(127.0.0.1)\nSlurmctldPort=" << port
            << "\nSlurmdPort="
            << port + 10'000
            // A job of a dead node starts again when its credential has expired.
            << "\nAuthInfo=cred_expire=5\nAuthType=auth/none\nCredType=cred/"
               "none\nSlurmUser="
            << user << "\nSlurmdUser=" << user << "\n"
            << "StateSaveLocation=" << in << "state\nSlurmdSpoolDir=" << in << "spool\n"
            << "SlurmctldPidFile=" << in << "ctld.pid\nSlurmdPidFile=" << in << "d.pid\n"
            << "ProctrackType=proctrack/pgid\nTaskPlugin=task/none\nMpiDefault=none\n"
            << "SelectType=select/cons_tres\nSelectTypeParameters=CR_CPU\nReturnToService=2\n"
            << "SwitchType=switch/none\nSchedulerParameters=batch_sched_delay=0,sched_interval=1\n"
            << "NodeName=localhost NodeAddr=127.0.0.1 CPUs=1 State=UNKNOWN\n"
            << "PartitionName=all Nodes=localhost Default=YES MaxTime=INFINITE State=UP\n";
        ::setenv("SLURM_CONF", (folder_ / "slurm.conf").c_str(), 1);
        controller_ = start("slurmctld", {"-D"});
        node_ = start_node();
        ASSERT_TRUE(eventually([] {
            return run_program("sinfo", {"--noheader", "--format=%T"}).output.starts_with("idle");
        }));
        std::ofstream(folder_ / "small.toml")
            << "duration = 1\nretry = 0.3\nstart_within = 60\ndrain = 20\npublish_within = 30\n"
            << "output = \"" << (folder_ / "out").string()
            << "\"\n[axes]\nbrokers = 1\nrobots = [2, 3, 4]\nrate = 10\nqos = \"1\"\n";
    }
    std::unique_ptr<BrokerProcess> start_node() {
        return start("slurmd", {"-D", "-N", "localhost"});
    }
    /// With all that it runs: what has this test's SLURM_CONF, but for the controller and the test.
    void kill_node() {
        const std::string ours = "SLURM_CONF=" + (folder_ / "slurm.conf").string();
        for (const auto& entry : fs::directory_iterator("/proc")) {
            const int pid = std::atoi(entry.path().filename().c_str());
            if (pid == 0 || pid == ::getpid() || pid == controller_->pid()) continue;
            if (process_file(pid, "environ").find(ours) != std::string::npos) ::kill(pid, SIGKILL);
        }
    }
    Ran submit(int shards) const {
        return run_romano("sweep " + (folder_ / "small.toml").string() + " --slurm " +
                          std::to_string(shards));
    }
    [[nodiscard]] std::vector<RunRow> rows(const std::string& folder) const {
        if (!fs::exists(folder_ / folder / "runs.csv")) return {};
        return read_results(folder_ / folder).rows;
    }
    [[nodiscard]] std::string read(const std::string& file) const {
        std::ifstream stream(folder_ / file);
        return {std::istreambuf_iterator<char>(stream), {}};
    }
    static bool eventually(const std::function<bool()>& done) {
        const auto end = std::chrono::steady_clock::now() + 120s;
        while (!done()) {
            if (std::chrono::steady_clock::now() > end) return false;
            std::this_thread::sleep_for(100ms);
        }
        return true;
    }
    [[nodiscard]] bool is_reported() const {
        return read("out-shards/slurm-merge.txt").find("Report: ") != std::string::npos;
    }

    tests::TemporaryFolder folder_;
    std::unique_ptr<BrokerProcess> controller_, node_;

private:
    std::unique_ptr<BrokerProcess> start(const std::string& name,
                                         const std::vector<std::string>& arguments) const {
        return std::make_unique<BrokerProcess>(name, "/usr/sbin/" + name, arguments,
                                               folder_ / (name + ".txt"));
    }
};

TEST_F(Slurm, RunsEachCellOnceAndReports) {
    const Ran submitted = submit(2);
    ASSERT_EQ(submitted.exit_code, 0) << submitted.output;
    EXPECT_THAT(submitted.output, HasSubstr("2 shards"));
    ASSERT_TRUE(eventually([this] { return is_reported(); })) << read("slurmctld.txt");
    ASSERT_THAT(rows("out"), SizeIs(3));
    for (const RunRow& row : rows("out")) EXPECT_EQ(row.status, "ok");
    EXPECT_THAT(read("out/report.html"), HasSubstr("3 of 3"));

    // Cut into other shards, nothing is left to do.
    fs::remove(folder_ / "out-shards/slurm-merge.txt");
    ASSERT_EQ(submit(3).exit_code, 0);
    ASSERT_TRUE(eventually([this] { return is_reported(); }));
    EXPECT_THAT(rows("out-shards/1-of-3"), SizeIs(0));
    EXPECT_THAT(rows("out"), SizeIs(3));
}

TEST_F(Slurm, AShardGoesOnAfterItsNodeDied) {
    ASSERT_EQ(submit(1).exit_code, 0);
    ASSERT_TRUE(eventually([this] { return rows("out-shards/1-of-1").size() == 1; }));
    kill_node();
    (void)run_program("scontrol", {"update", "NodeName=localhost", "State=DOWN", "Reason=died"});
    node_ = start_node();
    (void)run_program("scontrol", {"update", "NodeName=localhost", "State=RESUME"});
    ASSERT_TRUE(eventually([this] { return is_reported(); }))
        << read("slurmctld.txt") << read("out-shards/slurm-1.txt");
    ASSERT_THAT(rows("out"), SizeIs(3));
    EXPECT_THAT(read("out-shards/slurm-1.txt"), HasSubstr("were done before; going on"));
}

TEST_F(Slurm, WhatSbatchRefusesIsSaid) {
    const Ran ran = run_romano("sweep " + (folder_ / "small.toml").string() +
                               " --slurm 1 --slurm-option=--partition=nowhere");
    EXPECT_EQ(ran.exit_code, 2);
    EXPECT_THAT(ran.output, HasSubstr("--slurm: sbatch refused: "));
    EXPECT_THAT(ran.output, HasSubstr("partition"));
    EXPECT_EQ(std::ranges::count(ran.output, '\n'), 1) << ran.output;
}

}  // namespace
}  // namespace romano::experiments::slurm_test
