#include "broker/daemon/web_page.h"

#include <fcntl.h>
#include <sched.h>
#include <spdlog/spdlog.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <thread>

#include "broker/daemon/http_settings.h"
#include "broker/daemon/refusal.h"
#include "broker/net/clock.h"
#include "broker/net/endpoint_text.h"
#include "broker/net/socket_address.h"
#include "broker/net/tcp_acceptor.h"
#include "romano/keys/client_keys.h"
#include "romano/keys/key_error.h"

namespace romano::daemon {
namespace {

/// Nobody else has the address, and it is this machine's. A page whose broker was killed a moment
/// ago holds its own until the kernel has ended it.
boost::system::error_code why_not_open(const Endpoint& address) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds{1};
    for (;;) {
        boost::asio::io_context io;
        const auto error = net::TcpAcceptor(io, nullptr).open(address, 1);
        const bool may_change = error == boost::asio::error::address_in_use;
        if (!may_change || std::chrono::steady_clock::now() >= end) return error;
        std::this_thread::sleep_for(std::chrono::milliseconds{20});
    }
}

std::string program_beside_this_one(const std::string& name) {
    std::error_code unknown;
    return std::filesystem::read_symlink("/proc/self/exe", unknown).parent_path() / name;
}

/// In the new process, where only calls that are safe in a copy of one thread may be made.
[[noreturn]] void become(char* const* arguments, pid_t broker) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != broker) ::_exit(127);  // the broker died before that took hold
    ::setpgid(0, 0);                          // Ctrl-C is the broker's matter
    // It gives way to the broker: no realtime, less of the processor, and first when memory is out.
    const sched_param none{};
    ::sched_setscheduler(0, SCHED_OTHER, &none);
    (void)::nice(10);
    if (const int score = ::open("/proc/self/oom_score_adj", O_WRONLY); score >= 0) {
        (void)!::write(score, "500", 3);
    }
    std::signal(SIGPIPE, SIG_DFL);
    sigset_t nothing;
    ::sigemptyset(&nothing);
    ::sigprocmask(SIG_SETMASK, &nothing, nullptr);
    if (const int null = ::open("/dev/null", O_RDONLY); null >= 0) ::dup2(null, STDIN_FILENO);
    ::dup2(STDERR_FILENO, STDOUT_FILENO);  // what it says belongs to the trace
    // The broker's sockets would hold its addresses after its death.
    (void)::close_range(STDERR_FILENO + 1, ~0U, 0);
    ::execv(arguments[0], arguments);
    ::_exit(127);
}

std::string how_it_ended(int status) {
    if (WIFSIGNALED(status)) return "was killed by signal " + std::to_string(WTERMSIG(status));
    return "ended with exit code " + std::to_string(WEXITSTATUS(status));
}

}  // namespace

std::vector<std::string> web_arguments(const WebSettings& settings,
                                       const std::vector<Endpoint>& addresses) {
    const auto wanted = settings.key_file ? Endpoint::Packets::sealed : Endpoint::Packets::plain;
    Endpoint broker =
        net::as_reached_here(*std::ranges::find(addresses, wanted, &Endpoint::packets));
    broker.packets = Endpoint::Packets::plain;
    const std::string text = net::to_text(broker);
    std::string host = text.substr(0, text.rfind(':'));
    if (host.front() == '[') host = host.substr(1, host.size() - 2);
    std::vector<std::string> out{"web", "-h", host, "-p", std::to_string(broker.port)};
    if (settings.key_file) out.insert(out.end(), {"--key", *settings.key_file});
    out.insert(out.end(), {"--listen", net::to_text(settings.listen)});
    if (settings.gate) {
        out.insert(out.end(), {"--certificate", settings.gate->certificate.string(), "--token",
                               settings.gate->token.string()});
    } else if (!net::is_loopback(settings.listen)) {
        out.emplace_back("--let-everybody-steer");
    }
    return out;
}

WebPage::WebPage(boost::asio::io_context& io, const Settings& settings)
    : turns_(net::TurnClock::of(io)), settings_(settings.web), ends_(io), timer_(io) {
    if (!settings_) return;
    const std::string at = net::to_text(settings_->listen);
    program_ = program_beside_this_one("romano");
    if (::access(program_.c_str(), X_OK) != 0) {
        refuse_option("web", at,
                      "needs the program " + program_ + ", which is not there (" +
                          std::strerror(errno) +
                          "); install it beside romano-broker (Debian: package romano-tools), or "
                          "leave --web out");
    }
    if (settings_->key_file) {
        try {
            (void)keys::read_own_key(*settings_->key_file);
        } catch (const keys::KeyError& error) {
            refuse_option("web-key", *settings_->key_file, error.what());
        }
    }
    (void)open_gate("web-token", settings_->gate);
    if (const auto error = why_not_open(settings_->listen)) {
        refuse_option(
            "web", at,
            "cannot be served (" + error.message() + "); choose a free port of this machine");
    }
}

WebPage::~WebPage() {
    if (process_ == 0) return;
    ::kill(process_, SIGKILL);
    ::waitpid(process_, nullptr, 0);
}

void WebPage::show(const std::vector<Endpoint>& addresses) {
    if (!settings_) return;
    arguments_ = web_arguments(*settings_, addresses);
    arguments_.insert(arguments_.begin(), program_);
    ends_.add(SIGCHLD);
    wait_for_end();
    start();
}

void WebPage::start() {
    std::vector<char*> arguments;
    for (std::string& argument : arguments_) arguments.push_back(argument.data());
    arguments.push_back(nullptr);
    const pid_t broker = ::getpid();
    started_ = std::chrono::steady_clock::now();
    process_ = ::fork();
    if (process_ == 0) become(arguments.data(), broker);
    if (process_ < 0) {
        process_ = 0;
        on_end("cannot be started (" + std::string(std::strerror(errno)) + ")");
    }
}

void WebPage::wait_for_end() {
    ends_.async_wait([this](const boost::system::error_code& error, int) {
        if (error) return;
        turns_.begin(net::now());
        int status = 0;
        if (process_ != 0 && ::waitpid(process_, &status, WNOHANG) == process_) {
            process_ = 0;
            on_end(how_it_ended(status));
        }
        wait_for_end();
    });
}

void WebPage::on_end(const std::string& how) {
    const auto lived = std::chrono::steady_clock::now() - started_;
    pause_ = lived > longest_pause ? shortest_pause : pause_;
    spdlog::warn("the page at {}://{}/ {}; it is started again in {} s",
                 settings_->gate ? "https" : "http", net::to_text(settings_->listen), how,
                 pause_.count());
    timer_.expires_after(pause_);
    timer_.async_wait([this](const boost::system::error_code& stopped) {
        if (stopped) return;
        turns_.begin(net::now());
        start();
    });
    pause_ = std::min(2 * pause_, longest_pause);
}

}  // namespace romano::daemon
