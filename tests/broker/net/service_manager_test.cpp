// What systemd hears of a daemon, at a socket in systemd's place: sd_notify(3).
#include "broker/net/service_manager.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <cstddef>
#include <cstdlib>
#include <string>

namespace romano::net::service_manager_test {
namespace {

using namespace std::chrono_literals;

class ServiceManagerTest : public testing::Test {
protected:
    ServiceManagerTest() {
        const std::string name = "@romano-test-" + std::to_string(::getpid());
        sockaddr_un address{};
        address.sun_family = AF_UNIX;
        std::copy(name.begin() + 1, name.end(), address.sun_path + 1);
        const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + name.size());
        EXPECT_EQ(::bind(socket_, reinterpret_cast<sockaddr*>(&address), size), 0);
        ::setenv("NOTIFY_SOCKET", name.c_str(), 1);
    }
    ~ServiceManagerTest() override {
        ::unsetenv("NOTIFY_SOCKET");
        ::unsetenv("WATCHDOG_USEC");
        ::unsetenv("WATCHDOG_PID");
        ::close(socket_);
    }
    /// The next sentence; empty when none is there.
    std::string heard() {
        char text[256];
        const auto size = ::recv(socket_, text, sizeof text, MSG_DONTWAIT);
        return size > 0 ? std::string(text, static_cast<std::size_t>(size)) : "";
    }

    int socket_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    boost::asio::io_context io_;
};

TEST_F(ServiceManagerTest, HearsThatTheDaemonServesAndThatItEnds) {
    ServiceManager manager(io_);
    EXPECT_EQ(heard(), "");
    manager.serving("serving 127.0.0.1:1883");
    EXPECT_EQ(heard(), "READY=1\nSTATUS=serving 127.0.0.1:1883");
    manager.ending();
    EXPECT_EQ(heard(), "STOPPING=1");
    EXPECT_EQ(io_.run(), 0U);  // no timer holds the program
}

TEST_F(ServiceManagerTest, HearsSignsOfLifeAsLongAsTheLoopTurns) {
    ::setenv("WATCHDOG_USEC", "20000", 1);
    ::setenv("WATCHDOG_PID", std::to_string(::getpid()).c_str(), 1);
    ServiceManager manager(io_);
    manager.serving("");
    EXPECT_EQ(heard(), "READY=1\nSTATUS=");
    EXPECT_EQ(heard(), "WATCHDOG=1");  // and the loop has not turned yet
    EXPECT_EQ(heard(), "");
    for (int i = 0; i < 3; ++i) {
        io_.run_one();
        EXPECT_EQ(heard(), "WATCHDOG=1");
    }
    manager.ending();
    io_.run();
    EXPECT_EQ(heard(), "STOPPING=1");
    EXPECT_EQ(heard(), "");
}

TEST_F(ServiceManagerTest, HearsNoSignsThatAreMeantOfAnotherProcess) {
    ::setenv("WATCHDOG_USEC", "20000", 1);
    ::setenv("WATCHDOG_PID", "1", 1);
    ServiceManager manager(io_);
    manager.serving("");
    EXPECT_EQ(heard(), "READY=1\nSTATUS=");
    EXPECT_EQ(heard(), "");
}

TEST_F(ServiceManagerTest, MayBeMissing) {
    ::unsetenv("NOTIFY_SOCKET");
    ::setenv("WATCHDOG_USEC", "20000", 1);
    ServiceManager manager(io_);
    manager.serving("");
    manager.ending();
    EXPECT_EQ(io_.run(), 0U);
    EXPECT_EQ(heard(), "");
}

}  // namespace
}  // namespace romano::net::service_manager_test
