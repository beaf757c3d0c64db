// The line to a machine, with programs in ssh's place that behave as no machine should.

#include "experiments/testbed/host_channel.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "tests/temporary_folder.h"

namespace romano::experiments::host_channel_test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::SizeIs;

class Line : public ::testing::Test {
protected:
    Line() {
        host_.name = "pi1";
        host_.ssh = "pi1";
        ::setenv("PATH", (folder_.path().string() + ":" + path_).c_str(), 1);
    }
    ~Line() override { ::setenv("PATH", path_.c_str(), 1); }

    void be_ssh(const std::string& script) const {
        const fs::path file = folder_ / "ssh";
        std::ofstream(file) << "#!/bin/sh\n" << script << "\n";
        fs::permissions(file, fs::perms::owner_all);
    }
    std::string why_not(HostChannel& channel) {
        try {
            return "it said " + channel.ask({{"do", "time"}}, "time_s", 30s).dump();
        } catch (const std::exception& error) {
            return error.what();
        }
    }

    const std::string path_ = ::getenv("PATH");
    tests::TemporaryFolder folder_;
    SshFolder sockets_;
    Host host_;
    Ssh ssh_{host_, sockets_};
    boost::asio::io_context io_{1};
    std::vector<json> told_;
    HostChannel::OnWords hear_ = [this](const json& words) { told_.push_back(words); };
};

TEST_F(Line, PassesOverWhatIsNoObject) {
    be_ssh("echo Welcome; echo '[1]'; echo; echo '{\"usage\":[]}'; echo '{\"time_s\":7}'; cat");
    HostChannel channel{io_, ssh_, hear_};
    EXPECT_EQ(channel.ask({{"do", "time"}}, "time_s", 30s)["time_s"], 7);
    ASSERT_THAT(told_, SizeIs(1));
    EXPECT_TRUE(told_[0].contains("usage"));
}

TEST_F(Line, SaysWhatTheMachineSaysIsWrong) {
    be_ssh("echo '{\"error\":\"it burns\"}'; cat >/dev/null");
    HostChannel channel{io_, ssh_, hear_};
    EXPECT_EQ(why_not(channel), "it burns");
}

TEST_F(Line, IsGoneWhenSshEnds) {
    be_ssh("exit 255");
    HostChannel channel{io_, ssh_, hear_};
    EXPECT_EQ(why_not(channel), "its ssh connection ended");
}

TEST_F(Line, IsGoneWhenTheMachineIsSilent) {
    be_ssh("exec /bin/sleep 600");
    HostChannel channel{io_, ssh_, hear_};
    EXPECT_EQ(why_not(channel), "nothing was heard of it for 10 s");
}

TEST_F(Line, SaysThatNothingAnswersInTime) {
    be_ssh("while echo '{\"usage\":[]}'; do /bin/sleep 0.1; done");
    HostChannel channel{io_, ssh_, hear_};
    EXPECT_THROW((void)channel.ask({{"do", "time"}}, "time_s", 1s), std::runtime_error);
    EXPECT_FALSE(channel.is_gone());
}

}  // namespace
}  // namespace romano::experiments::host_channel_test
