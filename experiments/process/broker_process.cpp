#include "experiments/process/broker_process.h"

#include <sched.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <utility>

namespace romano::experiments {
namespace {

std::string last_line_of(const std::filesystem::path& file) {
    std::ifstream stream(file);
    std::string line;
    std::string last;
    while (std::getline(stream, line)) {
        if (!line.empty()) last = line;
    }
    return last;
}

/// What a child must know to become the program.
struct Start {
    const char* program;
    std::vector<char*> arguments;
    int output;
    pid_t parent = ::getpid();
    sigset_t no_signals{};
    int error = 0;
};

/// In the child, in our memory: only calls that are safe there.
int become(void* given) {
    Start& start = *static_cast<Start*>(given);
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != start.parent) return 127;  // the parent died before prctl took hold
    // Ctrl-C at the terminal goes to the sweep alone, which stops its brokers itself.
    ::setpgid(0, 0);
    ::sigprocmask(SIG_SETMASK, &start.no_signals, nullptr);
    ::dup2(start.output, STDOUT_FILENO);
    ::dup2(start.output, STDERR_FILENO);
    // A broker with thousands of robots' sockets has none left below FD_SETSIZE for DDS.
    (void)::close_range(STDERR_FILENO + 1, ~0U, CLOSE_RANGE_CLOEXEC);
    ::execv(start.program, start.arguments.data());
    start.error = errno;
    return 127;
}

/// As vfork() does, with a stack of the child's own. fork() copies the tables of our pages, and a
/// load generator has gigabytes: it would stand still for as long as what it measures.
pid_t start_child(Start& start) {
    alignas(16) std::array<std::byte, 65536> stack;
    return ::clone(become, stack.data() + stack.size(), CLONE_VM | CLONE_VFORK | SIGCHLD, &start);
}

}  // namespace

BrokerProcess::BrokerProcess(std::string name, const std::filesystem::path& program,
                             const std::vector<std::string>& arguments, std::filesystem::path trace)
    : name_(std::move(name)), trace_(std::move(trace)) {
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> output(std::fopen(trace_.c_str(), "we"),
                                                                 std::fclose);
    if (!output) throw std::runtime_error("cannot write `" + trace_.string() + "`");
    Start start{.program = program.c_str(), .arguments = {}, .output = ::fileno(output.get())};
    ::sigemptyset(&start.no_signals);
    start.arguments.push_back(const_cast<char*>(start.program));
    for (const std::string& argument : arguments) {
        start.arguments.push_back(const_cast<char*>(argument.c_str()));
    }
    start.arguments.push_back(nullptr);
    pid_ = start_child(start);
    const int error = pid_ < 0 ? errno : start.error;
    if (error == 0) return;
    if (pid_ > 0) reap(0);
    throw std::runtime_error("cannot start `" + program.string() +
                             "`: " + std::generic_category().message(error));
}

BrokerProcess::~BrokerProcess() {
    kill();
}

void BrokerProcess::kill() {
    if (wait_status_) return;
    ::kill(pid_, SIGKILL);
    reap(0);
}

void BrokerProcess::pause() {
    if (!wait_status_) ::kill(pid_, SIGSTOP);
}

void BrokerProcess::resume() {
    if (!wait_status_) ::kill(pid_, SIGCONT);
}

void BrokerProcess::ask_to_stop() {
    if (has_ended()) return;
    ::kill(pid_, SIGTERM);
    ::kill(pid_, SIGCONT);
}

void BrokerProcess::stop(std::chrono::milliseconds patience) {
    ask_to_stop();
    const auto deadline = std::chrono::steady_clock::now() + patience;
    while (!has_ended() && std::chrono::steady_clock::now() < deadline) {
        std::this_thread::sleep_for(std::chrono::milliseconds{2});
    }
    kill();
}

bool BrokerProcess::has_ended() {
    if (!wait_status_) reap(WNOHANG);
    return wait_status_.has_value();
}

std::string BrokerProcess::how_it_ended() const {
    std::string text = "still running";
    if (wait_status_ && WIFEXITED(*wait_status_)) {
        text = "exit code " + std::to_string(WEXITSTATUS(*wait_status_));
    } else if (wait_status_ && WIFSIGNALED(*wait_status_)) {
        const int signal = WTERMSIG(*wait_status_);
        text = "signal " + std::to_string(signal) + " (" + ::strsignal(signal) + ")";
    }
    const std::string last = last_line_of(trace_);
    return last.empty() ? text : text + ": " + last;
}

void BrokerProcess::expect_running() {
    if (has_ended()) throw std::runtime_error("broker " + name_ + " ended: " + how_it_ended());
}

void BrokerProcess::reap(int options) {
    int status = 0;
    pid_t ended = -1;
    do {
        ended = ::waitpid(pid_, &status, options);
    } while (ended < 0 && errno == EINTR);
    if (ended == pid_) wait_status_ = status;
}

}  // namespace romano::experiments
