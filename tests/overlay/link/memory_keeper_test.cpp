// A file in memory cannot be sealed against writing while somebody has it mapped (fcntl(2)): so it
// is known whether a dead process's memory is freed.

#include "overlay/link/memory_keeper.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <optional>

namespace romano::link::memory_keeper_test {
namespace {

/// A process with memory that we know of, and with the end of a pipe as its only file of interest.
class Process {
public:
    explicit Process(bool keeps_memory) {
        memory_ = ::memfd_create("memory", MFD_ALLOW_SEALING);
        EXPECT_EQ(::ftruncate(memory_, 4096), 0);
        std::array<int, 2> pipe{};
        std::array<int, 2> ready{};
        EXPECT_EQ(::pipe(pipe.data()), 0);
        EXPECT_EQ(::pipe(ready.data()), 0);
        process_ = ::fork();
        if (process_ == 0) {
            ::close(pipe[0]);
            ::mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_SHARED, memory_, 0);
            std::optional<MemoryKeeper> keeper;
            if (keeps_memory) keeper.emplace();
            (void)::write(ready[1], "", 1);
            for (;;) ::pause();
        }
        char octet = 0;
        EXPECT_EQ(::read(ready[0], &octet, 1), 1);
        for (const int end : {pipe[1], ready[0], ready[1]}) ::close(end);
        pipe_ = pipe[0];
    }
    ~Process() {
        ::close(pipe_);
        ::close(memory_);
    }
    Process(const Process&) = delete;
    Process& operator=(const Process&) = delete;

    void die() const { ::kill(process_, SIGKILL); }
    void bury() const { EXPECT_EQ(::waitpid(process_, nullptr, 0), process_); }
    void await_end_of_files() const {
        pollfd waiting{.fd = pipe_, .events = POLLIN, .revents = 0};
        EXPECT_EQ(::poll(&waiting, 1, 10'000), 1);
        EXPECT_NE(waiting.revents & POLLHUP, 0);
    }
    [[nodiscard]] bool has_memory() const {
        return ::fcntl(memory_, F_ADD_SEALS, F_SEAL_WRITE) != 0;
    }

private:
    int memory_ = -1;
    int pipe_ = -1;
    pid_t process_ = -1;
};

// Whoever looks too late sees neither: several looks.
bool ends_files_before_memory(bool keeps_memory) {
    for (int look = 0; look < 20; ++look) {
        const Process process(keeps_memory);
        process.die();
        process.await_end_of_files();
        const bool has_memory = process.has_memory();
        process.bury();
        if (has_memory) return true;
    }
    return false;
}

class MemoryKeeperTest : public testing::Test {
protected:
    void SetUp() override {
        if (!MemoryKeeper().was_started()) GTEST_SKIP() << "there are no such processes here";
    }
};

TEST_F(MemoryKeeperTest, TheFilesOfADeadProcessAreClosedBeforeItsMemoryIsFreed) {
    EXPECT_TRUE(ends_files_before_memory(true));
    EXPECT_FALSE(ends_files_before_memory(false)) << "the kernel does so by itself";
}

TEST_F(MemoryKeeperTest, TheMemoryOfADeadProcessIsFreedInTheEnd) {
    const Process process(true);
    EXPECT_TRUE(process.has_memory());
    process.die();
    process.bury();
    for (int tenths = 0; tenths < 100 && process.has_memory(); ++tenths) {
        ::poll(nullptr, 0, 100);
    }
    EXPECT_FALSE(process.has_memory());
}

TEST_F(MemoryKeeperTest, ItEndsWhenItIsDismissed) {
    { const MemoryKeeper keeper; }
    EXPECT_EQ(::waitpid(-1, nullptr, __WALL | WNOHANG), -1) << "no process is left";
}

}  // namespace
}  // namespace romano::link::memory_keeper_test
