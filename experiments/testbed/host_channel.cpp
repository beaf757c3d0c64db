#include "experiments/testbed/host_channel.h"

#include <signal.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <boost/asio/read_until.hpp>
#include <boost/asio/write.hpp>
#include <boost/process/args.hpp>
#include <boost/process/child.hpp>
#include <boost/process/exe.hpp>
#include <boost/process/extend.hpp>
#include <boost/process/io.hpp>
#include <boost/process/posix.hpp>
#include <cerrno>
#include <csignal>
#include <istream>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <utility>

namespace romano::experiments {
namespace {

namespace process = boost::process;
using namespace std::chrono_literals;
using nlohmann::json;

constexpr auto look_every = 1s;
constexpr int most_silent_looks = 10;
constexpr auto ends_within = 5s;
constexpr std::size_t longest_line = 256 << 20;  // of all traces of a cell
constexpr std::size_t most_to_say = 1000;

}  // namespace

HostChannel::HostChannel(boost::asio::io_context& io, const Ssh& ssh, OnWords on_words)
    : io_(io),
      ssh_(ssh),
      on_words_(std::move(on_words)),
      socket_(io),
      heard_(longest_line),
      timer_(io) {
    std::array<int, 2> ends{};
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) {
        throw std::runtime_error("no socket for ssh");
    }
    socket_.assign({}, ends[0]);
    const pid_t parent = ::getpid();
    const auto prepare = [parent](auto&) {
        // Nobody speaks for a caller that is gone: ssh ends, and so does all that runs there.
        ::prctl(PR_SET_PDEATHSIG, SIGKILL);
        if (::getppid() != parent) ::_exit(127);
        ::setpgid(0, 0);  // Ctrl-C goes to the caller alone, which ends things in their order
        sigset_t none;
        ::sigemptyset(&none);
        ::sigprocmask(SIG_SETMASK, &none, nullptr);
        (void)::close_range(STDERR_FILENO + 1, ~0U, CLOSE_RANGE_CLOEXEC);
    };
    std::vector<std::string> words = {"ssh"};
    const std::string line = romano_host(ssh.host(), "session --ssh \"$SSH_CONNECTION\"");
    for (std::string& word : ssh.arguments(line)) words.push_back(std::move(word));
    std::error_code failed;
    // env looks for ssh on PATH.
    process::child child(process::exe = "/usr/bin/env", process::args = words,
                         process::posix::fd.bind(STDIN_FILENO, ends[1]),
                         process::posix::fd.bind(STDOUT_FILENO, ends[1]),
                         process::std_err > process::null, process::extend::on_exec_setup = prepare,
                         failed);
    ::close(ends[1]);
    if (failed) throw std::runtime_error("cannot start ssh: " + failed.message());
    pid_ = child.id();
    child.detach();
    read();
    look();
}

HostChannel::~HostChannel() {
    alive_.reset();
    boost::system::error_code ignored;
    socket_.shutdown(boost::asio::socket_base::shutdown_send, ignored);
    const auto deadline = std::chrono::steady_clock::now() + (is_gone() ? 0s : ends_within);
    int status = 0;
    pid_t ended = 0;
    while ((ended = ::waitpid(pid_, &status, WNOHANG)) == 0 &&
           std::chrono::steady_clock::now() < deadline) {
        std::this_thread::sleep_for(5ms);
    }
    if (ended != 0) return;
    ::kill(pid_, SIGKILL);
    while (::waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
    }
}

void HostChannel::read() {
    boost::asio::async_read_until(
        socket_, heard_, '\n',
        [this, alive = std::weak_ptr{alive_}](const auto& error, std::size_t) {
            if (alive.expired()) return;
            if (error) return lose("its ssh connection ended");
            silent_looks_ = 0;
            std::istream lines(&heard_);
            std::string line;
            std::getline(lines, line);
            on_line(line);
            read();
        });
}

void HostChannel::on_line(const std::string& line) {
    const json words = json::parse(line, nullptr, false);
    if (!words.is_object()) return;  // some shells greet
    if (!awaited_key_.empty() && words.contains(awaited_key_)) {
        answer_ = words;
    } else if (!awaited_key_.empty() && words.contains("error") && words["error"].is_string()) {
        error_ = words["error"];
    } else {
        on_words_(words);
    }
}

void HostChannel::tell(const json& words) {
    if (is_gone()) return;
    if (to_say_.size() >= most_to_say) return lose("it takes nothing more");
    to_say_.push_back(words.dump() + '\n');
    if (!is_writing_) write();
}

void HostChannel::write() {
    is_writing_ = true;
    boost::asio::async_write(socket_, boost::asio::buffer(to_say_.front()),
                             [this, alive = std::weak_ptr{alive_}](const auto& error, std::size_t) {
                                 if (alive.expired()) return;
                                 is_writing_ = false;
                                 if (error) return lose("its ssh connection ended");
                                 to_say_.pop_front();
                                 if (!to_say_.empty()) write();
                             });
}

void HostChannel::begin_asking(const json& words, const std::string& key) {
    answer_.reset();
    error_.clear();
    awaited_key_ = key;
    tell(words);
}

json HostChannel::await_answer(std::chrono::seconds patience) {
    const auto deadline = std::chrono::steady_clock::now() + patience;
    io_.restart();
    while (!answer_ && error_.empty() && !is_gone() &&
           std::chrono::steady_clock::now() < deadline) {
        io_.run_one_for(20ms);
    }
    awaited_key_.clear();
    if (answer_) return *answer_;
    if (is_gone()) throw std::runtime_error(why_gone());
    if (!error_.empty()) throw std::runtime_error(error_);
    throw std::runtime_error("no answer within " + std::to_string(patience.count()) + " s");
}

void HostChannel::look() {
    if (is_gone()) return;
    if (++silent_looks_ > most_silent_looks) return lose("nothing was heard of it for 10 s");
    tell({{"do", "alive"}});
    timer_.expires_after(look_every);
    timer_.async_wait([this, alive = std::weak_ptr{alive_}](const auto& error) {
        if (!error && !alive.expired()) look();
    });
}

void HostChannel::lose(const std::string& why) {
    if (why_gone_.empty()) why_gone_ = why;
}

}  // namespace romano::experiments
