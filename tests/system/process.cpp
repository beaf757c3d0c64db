#include "tests/system/process.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <utility>

namespace romano::system {
namespace {

using Clock = std::chrono::steady_clock;

struct Pipe {
    int read_end = -1;
    int write_end = -1;
};

Pipe make_pipe() {
    std::array<int, 2> ends{-1, -1};
    EXPECT_EQ(pipe2(ends.data(), O_CLOEXEC), 0);
    return {ends[0], ends[1]};
}

}  // namespace

Process::Output::~Output() {
    close(end_);
}

bool Process::Output::read(std::chrono::milliseconds limit) {
    pollfd ready{.fd = end_, .events = POLLIN, .revents = 0};
    if (poll(&ready, 1, static_cast<int>(limit.count())) != 1) return false;
    std::array<char, 4096> octets{};
    const ssize_t size = ::read(end_, octets.data(), octets.size());
    if (size <= 0) return false;
    text.append(octets.data(), static_cast<std::size_t>(size));
    return true;
}

Process::Output Process::start(const std::string& program,
                               const std::vector<std::string>& arguments, pid_t& pid,
                               int& errors_end) {
    const Pipe output = make_pipe();
    const Pipe errors = make_pipe();
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, output.write_end, STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions, errors.write_end, STDERR_FILENO);
    // The kernel kills it when the test dies, also by a time-out of ctest.
    std::vector<std::string> words{"/usr/bin/setpriv", "--pdeathsig", "KILL", program};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> argv;
    argv.reserve(words.size() + 1);
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    EXPECT_EQ(posix_spawn(&pid, argv[0], &actions, nullptr, argv.data(), environ), 0);
    posix_spawn_file_actions_destroy(&actions);
    close(output.write_end);
    close(errors.write_end);
    errors_end = errors.read_end;
    return Output(output.read_end);
}

Process::Process(const std::string& program, const std::vector<std::string>& arguments)
    : output_(start(program, arguments, pid_, errors_end_)), errors_(errors_end_) {}

Process::~Process() {
    if (testing::Test::HasFailure()) {
        std::printf("--- stderr of process %d:\n%s---\n", pid_, errors().c_str());
    }
    kill_9();
}

std::string Process::next_line(std::chrono::milliseconds limit) {
    const auto deadline = Clock::now() + limit;
    for (;;) {
        const auto end = output_.text.find('\n');
        if (end != std::string::npos) {
            std::string line = output_.text.substr(0, end);
            output_.text.erase(0, end + 1);
            return line;
        }
        const auto left =
            std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now());
        if (left.count() <= 0 || !output_.read(left)) return {};
    }
}

std::string Process::wait_for(const std::string& words, std::chrono::milliseconds limit) {
    const auto deadline = Clock::now() + limit;
    while (Clock::now() < deadline) {
        const auto left =
            std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now());
        std::string line = next_line(left);
        if (line.find(words) != std::string::npos) return line;
        if (line.empty()) break;
    }
    return {};
}

std::string Process::rest_of_output() {
    while (output_.read(default_limit)) {
    }
    return std::exchange(output_.text, {});
}

void Process::signal(int number) const {
    if (pid_ > 0) kill(pid_, number);
}

int Process::wait_for_exit(std::chrono::milliseconds limit) {
    const auto deadline = Clock::now() + limit;
    int status = 0;
    while (waitpid(pid_, &status, WNOHANG) == 0) {
        if (Clock::now() >= deadline) return -1;
        usleep(1000);
    }
    pid_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

void Process::kill_9() {
    if (pid_ <= 0) return;
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
    pid_ = -1;
}

const std::string& Process::errors() {
    while (errors_.read(std::chrono::milliseconds{0})) {
    }
    return errors_.text;
}

}  // namespace romano::system
