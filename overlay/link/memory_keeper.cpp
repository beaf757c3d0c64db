#include "overlay/link/memory_keeper.h"

#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstddef>
#include <cstdint>
#include <ctime>

namespace romano::link {
namespace {

constexpr std::size_t stack_octets = 64U << 10U;
/// What the survivors do about a death is done by then.
constexpr long keeps_for_ns = 100'000'000;

/// The second process. It has the first one's thread-local memory as well, errno for example: it
/// makes system calls, which do not fail while the first one lives, and nothing else.
#if defined(__clang__)
__attribute__((disable_sanitizer_instrumentation))
#else
__attribute__((no_sanitize("address", "thread", "undefined")))
#endif
int keep_memory(void* parent) {
    // Files that it held would be held too long: rather not at all (Linux before 5.9).
    if (::syscall(SYS_close_range, 0, ~0U, 0) != 0) ::syscall(SYS_exit_group, 0);
    ::syscall(SYS_prctl, PR_SET_NAME, "romano-memory");
    const sched_param none{};
    ::syscall(SYS_sched_setscheduler, 0, SCHED_IDLE, &none);
    ::syscall(SYS_prctl, PR_SET_PDEATHSIG, SIGUSR1);  // that thread's death, in fact
    if (::syscall(SYS_getppid) == static_cast<long>(reinterpret_cast<std::intptr_t>(parent))) {
        const std::uint64_t death = std::uint64_t{1} << (SIGUSR1 - 1);
        while (::syscall(SYS_rt_sigtimedwait, &death, nullptr, nullptr, sizeof death) != SIGUSR1) {
        }
    }
    const timespec a_moment{.tv_sec = 0, .tv_nsec = keeps_for_ns};
    ::syscall(SYS_nanosleep, &a_moment, nullptr);
    ::syscall(SYS_exit_group, 0);
    return 0;
}

}  // namespace

MemoryKeeper::MemoryKeeper() {
    void* stack =
        ::mmap(nullptr, stack_octets, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (stack == MAP_FAILED) return;
    stack_ = stack;
    // No handler of ours may run there.
    sigset_t all{};
    sigset_t before{};
    ::sigfillset(&all);
    ::pthread_sigmask(SIG_SETMASK, &all, &before);
    process_ = ::clone(keep_memory, static_cast<std::byte*>(stack) + stack_octets, CLONE_VM,
                       reinterpret_cast<void*>(static_cast<std::intptr_t>(::getpid())));
    ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

MemoryKeeper::~MemoryKeeper() {
    if (process_ > 0) {
        ::kill(process_, SIGKILL);
        ::waitpid(process_, nullptr, __WALL);
    }
    if (stack_ != nullptr) ::munmap(stack_, stack_octets);
}

}  // namespace romano::link
