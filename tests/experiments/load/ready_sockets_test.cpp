// Waiting for sockets is the same with epoll_pwait2, which Linux has since 5.11, and without.

#include "experiments/load/ready_sockets.h"

#include <gtest/gtest.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/eventfd.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <functional>
#include <thread>

#include "broker/net/clock.h"

namespace romano::experiments::ready_sockets_test {
namespace {

using namespace std::chrono_literals;

enum class Kernel { current, before_5_11 };

/// From now on this thread gets ENOSYS for epoll_pwait2. (Where that is refused, as by qemu-user,
/// it is like that anyway.)
void forget_epoll_pwait2() {
    std::array<sock_filter, 4> rules = {
        sock_filter BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
        sock_filter BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_epoll_pwait2, 0, 1),
        sock_filter BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | ENOSYS),
        sock_filter BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW)};
    const sock_fprog program{.len = rules.size(), .filter = rules.data()};
    (void)::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
    (void)::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program);
    EXPECT_EQ(::syscall(SYS_epoll_pwait2, -1, nullptr, 0, nullptr, nullptr, 0), -1);
    EXPECT_EQ(errno, ENOSYS);
}

class ReadySockets : public testing::TestWithParam<Kernel> {
protected:
    ReadySockets() {
        epoll_event event{.events = EPOLLIN, .data = {.u32 = 7}};
        EXPECT_EQ(::epoll_ctl(epoll, EPOLL_CTL_ADD, socket, &event), 0);
    }
    ~ReadySockets() override {
        ::close(socket);
        ::close(epoll);
    }
    static void run(const std::function<void()>& test) {
        std::thread{[&] {
            if (GetParam() == Kernel::before_5_11) forget_epoll_pwait2();
            test();
        }}.join();
    }

    int epoll = ::epoll_create1(EPOLL_CLOEXEC);
    int socket = ::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    std::array<epoll_event, 4> room{};
};

TEST_P(ReadySockets, AreToldAsSoonAsTheyAre) {
    run([&] {
        ASSERT_EQ(::eventfd_write(socket, 1), 0);
        const auto ready = wait_for_sockets(epoll, net::now() + 1h, room);
        ASSERT_EQ(ready.size(), 1u);
        EXPECT_EQ(ready.front().data.u32, 7u);
    });
}

TEST_P(ReadySockets, AreWaitedForUntilTheTimeThatWasGiven) {
    run([&] {
        const Instant until = net::now() + 20ms;
        EXPECT_TRUE(wait_for_sockets(epoll, until, room).empty());
        EXPECT_GE(net::now(), until);
    });
}

TEST_P(ReadySockets, AreNotWaitedForWhenTheTimeIsPast) {
    run([&] { EXPECT_TRUE(wait_for_sockets(epoll, net::now() - 1h, room).empty()); });
}

INSTANTIATE_TEST_SUITE_P(Linux, ReadySockets, testing::Values(Kernel::current, Kernel::before_5_11),
                         [](const auto& param) {
                             return param.param == Kernel::current ? "Current" : "Before511";
                         });

}  // namespace
}  // namespace romano::experiments::ready_sockets_test
