#include "experiments/testbed/host/host_session.h"

#include <stdlib.h>
#include <unistd.h>

#include <boost/asio/read_until.hpp>
#include <cerrno>
#include <istream>
#include <thread>
#include <utility>

#include "experiments/testbed/host/gather_facts.h"
#include "experiments/testbed/host/keeper.h"

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;

constexpr auto look_every = 100ms;
constexpr int most_silent_looks = 100;  // of our own clock: a standstill of ours is no silence
/// A session whose connection broke down needs so long to notice it.
constexpr auto machine_is_free_within = 15s;
constexpr std::size_t longest_line = 1 << 20;
constexpr unsigned write_patience_s = 60;

double unix_time_s() {
    return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch())
        .count();
}

}  // namespace

HostSession::HostSession(boost::asio::io_context& io, std::filesystem::path programs, SshPath ssh)
    : io_(io),
      programs_(std::move(programs)),
      ssh_(std::move(ssh)),
      input_(io, ::dup(STDIN_FILENO)),
      heard_(longest_line),
      timer_(io) {
    read();
    look();
}

HostSession::~HostSession() {
    brokers_.reset();
    if (is_cut_) mend_network();
    if (traces_.empty()) return;
    std::error_code ignored;
    std::filesystem::remove_all(traces_, ignored);
}

void HostSession::read() {
    boost::asio::async_read_until(input_, heard_, '\n', [this](const auto& error, std::size_t) {
        if (error) return end();
        silent_looks_ = 0;
        std::istream lines(&heard_);
        std::string line;
        std::getline(lines, line);
        on_line(line);
        read();
    });
}

void HostSession::on_line(const std::string& line) {
    try {
        answer(json::parse(line));
    } catch (const std::exception& error) {
        say({{"error", error.what()}});
    }
}

void HostSession::answer(const json& asked) {
    const std::string what = asked.at("do");
    const auto number = [&asked] { return asked.at("number").get<std::uint32_t>(); };
    if (what == "alive") return;
    if (what == "time") return say({{"time_s", unix_time_s()}});
    if (what == "facts") {
        if (who_has_the_machine().empty()) mend_network();  // of a session that was killed
        return say({{"facts", gather_facts(asked.at("of").get<FactsRequest>(), programs_)}});
    }
    if (what == "listen") {
        trial_ = std::make_unique<MulticastTrial>(asked.at("name").get<std::string>(),
                                                  asked.at("interface").get<std::string>());
        return say({{"trouble", trial_->trouble()}, {"longest_octets", trial_->longest_octets()}});
    }
    if (what == "shout") {
        if (trial_) trial_->shout();
        return say({{"trouble", trial_ ? trial_->trouble() : ""}});
    }
    if (what == "heard") {
        return say({{"heard", trial_ ? trial_->heard() : std::map<std::string, int>{}}});
    }
    if (what == "begin") return begin(asked);
    if (what == "keep") return say(keep_running(asked.at("order").get<KeptPrograms>(), programs_));
    if (what == "kept") return say(what_is_kept(asked.at("folder").get<std::string>()));
    if (what == "drop") return say(end_keeping(asked.at("folder").get<std::string>()));
    if (!brokers_) throw std::runtime_error("`" + what + "` before `begin`");
    if (what == "start") return brokers_->start(asked.at("order").get<ProgramOrder>());
    if (what == "kill") return brokers_->kill(number());
    if (what == "pause") return brokers_->pause(number());
    if (what == "resume") return brokers_->resume(number());
    if (what == "ask_to_stop") return brokers_->ask_to_stop(number());
    if (what == "cut") {
        is_cut_ = true;
        const std::string trouble = cut_off(interface_, ssh_);
        if (!trouble.empty()) say({{"trouble", "fault `cut`: " + trouble}});
        return;
    }
    if (what == "mend") {
        mend_network();
        is_cut_ = false;
        return;
    }
    if (what == "stop") return stop();
    throw std::runtime_error("`" + what + "` is unknown here: is this romano-host older?");
}

void HostSession::begin(const json& asked) {
    const auto deadline = std::chrono::steady_clock::now() + machine_is_free_within;
    while (!claim_ && std::chrono::steady_clock::now() < deadline) {
        claim_ = MachineClaim::take(Holder::sweep);
        if (claim_ || who_has_the_machine() == "romano testbed start") break;
        say({{"usage", json::array()}});  // we live
        std::this_thread::sleep_for(50ms);
    }
    if (!claim_) {
        return say({{"begun", false}, {"trouble", "it is taken by " + who_has_the_machine()}});
    }
    std::string folder = std::filesystem::temp_directory_path() / "romano-host-XXXXXX";
    if (::mkdtemp(folder.data()) == nullptr) {
        return say({{"begun", false}, {"trouble", "no folder can be made for traces"}});
    }
    traces_ = folder;
    interface_ = asked.at("interface");
    mend_network();
    brokers_ = std::make_unique<HostBrokers>(programs_, traces_,
                                             asked.at("addresses").get<std::vector<std::string>>());
    say({{"begun", true}});
}

void HostSession::stop() {
    const auto pages = brokers_->metrics();
    brokers_->stop_all();
    say({{"stopped", true}, {"traces", brokers_->traces()}, {"metrics", pages}});
}

void HostSession::look() {
    if (++silent_looks_ > most_silent_looks) return end();
    json usage = json::array();
    if (brokers_) {
        for (const auto& [number, life, how] : brokers_->look()) {
            say({{"ended", number}, {"life", life}, {"how", how}});
        }
        for (const auto& [number, life, used] : brokers_->usage()) {
            usage.push_back({number, life, used.cpu_s, used.rss_mib, used.rss_peak_mib});
        }
        const auto now = std::chrono::steady_clock::now();
        if (now - leases_renewed_ > 1s) {
            leases_renewed_ = now;
            brokers_->renew_leases();
        }
    }
    say({{"usage", usage}});  // also a sign of life
    timer_.expires_after(look_every);
    timer_.async_wait([this](const auto& error) {
        if (!error) look();
    });
}

void HostSession::say(const json& words) {
    // What programs print may be no UTF-8.
    const std::string line = words.dump(-1, ' ', false, json::error_handler_t::replace) + '\n';
    std::string_view left = line;
    ::alarm(write_patience_s);  // nobody reads: the kernel ends us, and what we started with us
    while (!left.empty()) {
        const ssize_t written = ::write(STDOUT_FILENO, left.data(), left.size());
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) return end();
        left.remove_prefix(static_cast<std::size_t>(written));
    }
    ::alarm(0);
}

void HostSession::end() {
    ::alarm(0);
    io_.stop();
}

}  // namespace romano::experiments
