#include "experiments/process/broker_process.h"

#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <boost/process/args.hpp>
#include <boost/process/child.hpp>
#include <boost/process/exe.hpp>
#include <boost/process/extend.hpp>
#include <boost/process/io.hpp>
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

namespace process = boost::process;

std::string last_line_of(const std::filesystem::path& file) {
    std::ifstream stream(file);
    std::string line;
    std::string last;
    while (std::getline(stream, line)) {
        if (!line.empty()) last = line;
    }
    return last;
}

}  // namespace

BrokerProcess::BrokerProcess(std::string name, const std::filesystem::path& program,
                             const std::vector<std::string>& arguments, std::filesystem::path trace)
    : name_(std::move(name)), trace_(std::move(trace)) {
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> output(std::fopen(trace_.c_str(), "we"),
                                                                 std::fclose);
    if (!output) throw std::runtime_error("cannot write `" + trace_.string() + "`");
    const pid_t parent = ::getpid();
    // In the child, before exec: only calls that are safe there.
    const auto prepare = [parent](auto&) {
        ::prctl(PR_SET_PDEATHSIG, SIGKILL);
        if (::getppid() != parent) ::_exit(127);  // the parent died before prctl took hold
        // Ctrl-C at the terminal goes to the sweep alone, which stops its brokers itself.
        ::setpgid(0, 0);
        sigset_t none;
        ::sigemptyset(&none);
        ::sigprocmask(SIG_SETMASK, &none, nullptr);
        // A broker with thousands of robots' sockets has none left below FD_SETSIZE for DDS.
        (void)::close_range(STDERR_FILENO + 1, ~0U, CLOSE_RANGE_CLOEXEC);
    };
    std::error_code failed;
    process::child child(process::exe = program.string(), process::args = arguments,
                         (process::std_out & process::std_err) > output.get(),
                         process::extend::on_exec_setup = prepare, failed);
    if (failed) {
        throw std::runtime_error("cannot start `" + program.string() + "`: " + failed.message());
    }
    pid_ = child.id();
    child.detach();  // we wait for it ourselves: SIGSTOP and how it ended are beyond Boost.Process
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
