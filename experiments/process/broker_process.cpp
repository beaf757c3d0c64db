#include "experiments/process/broker_process.h"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <thread>

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

/// Between fork and exec: only calls that are safe there. Ends the child when exec fails.
[[noreturn]] void become(const char* program, char* const* arguments, int output, pid_t parent) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != parent) ::_exit(127);  // the parent died before prctl took hold
    // Ctrl-C at the terminal goes to the sweep alone, which stops its brokers itself.
    ::setpgid(0, 0);
    sigset_t none;
    ::sigemptyset(&none);
    ::sigprocmask(SIG_SETMASK, &none, nullptr);
    ::dup2(output, STDOUT_FILENO);
    ::dup2(output, STDERR_FILENO);
    ::execv(program, arguments);
    const char* reason = std::strerror(errno);
    const auto written = ::write(STDERR_FILENO, reason, std::strlen(reason));
    ::_exit(written < 0 ? 126 : 127);
}

}  // namespace

BrokerProcess::BrokerProcess(std::string name, const std::filesystem::path& program,
                             const std::vector<std::string>& arguments, std::filesystem::path trace)
    : name_(std::move(name)), trace_(std::move(trace)) {
    const int output = ::open(trace_.c_str(), O_CREAT | O_TRUNC | O_WRONLY | O_CLOEXEC, 0644);
    if (output < 0) throw std::runtime_error("cannot write `" + trace_.string() + "`");
    std::string own_name = program.string();
    std::vector<std::string> texts = arguments;
    std::vector<char*> pointers{own_name.data()};
    for (std::string& text : texts) pointers.push_back(text.data());
    pointers.push_back(nullptr);

    const pid_t parent = ::getpid();
    pid_ = ::fork();
    if (pid_ == 0) become(own_name.c_str(), pointers.data(), output, parent);
    ::close(output);
    if (pid_ < 0) {
        throw std::runtime_error(std::string{"cannot start a process: "} + std::strerror(errno));
    }
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
