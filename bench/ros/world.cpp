#include "bench/ros/world.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <thread>
#include <utility>

#include "broker/net/clock.h"
#include "experiments/process/process_usage.h"

namespace romano::bench::ros {
namespace {

using namespace std::chrono_literals;
namespace fs = std::filesystem;
using experiments::BrokerProcess;
using experiments::Lan;

constexpr auto patience = 60s;  // for whatever must happen before a measurement begins
constexpr auto farewell = 10s;
constexpr auto look_every = 20ms;

volatile std::sig_atomic_t interrupted = 0;

const Lan& built(const Lan& lan) {
    if (!lan.why_not().empty()) throw std::runtime_error(lan.why_not());
    return lan;
}

std::string text_of(const fs::path& file) {
    std::ifstream stream(file);
    return {std::istreambuf_iterator<char>(stream), {}};
}

bool accepts_tcp(const std::string& address, int port) {
    const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<std::uint16_t>(port));
    ::inet_pton(AF_INET, address.c_str(), &to.sin_addr);
    const bool accepted = ::connect(socket, reinterpret_cast<sockaddr*>(&to), sizeof to) == 0;
    ::close(socket);
    return accepted;
}

/// All its threads, in nanoseconds of the scheduler rather than in ticks.
double cpu_s_of(pid_t process) {
    clockid_t clock{};
    timespec used{};
    if (::clock_getcpuclockid(process, &clock) != 0 || ::clock_gettime(clock, &used) != 0) return 0;
    return static_cast<double>(used.tv_sec) + static_cast<double>(used.tv_nsec) * 1e-9;
}

Usage usage_of(const std::vector<std::unique_ptr<BrokerProcess>>& processes) {
    Usage sum;
    for (const auto& process : processes) {
        if (!process) continue;
        sum.cpu_s += cpu_s_of(process->pid());
        if (const auto usage = experiments::usage_of(process->pid())) sum.rss_mib += usage->rss_mib;
    }
    return sum;
}

}  // namespace

void heed_interrupts() {
    // With SA_RESTART, as glibc has it: the process that waits for a run goes on waiting.
    std::signal(SIGINT, [](int) { interrupted = 1; });
    std::signal(SIGTERM, [](int) { interrupted = 1; });
}

World::World(Contestant contestant, int nodes, fs::path programs, const fs::path& scratch)
    : contestant_(std::move(contestant)),
      programs_(std::move(programs)),
      folder_(scratch),
      lan_(contestant_.brokers + nodes),
      tap_(built(lan_), contestant_.brokers + nodes),
      nodes_(static_cast<std::size_t>(nodes)) {
    fs::create_directories(folder_);
    // ROS 1 writes logs wherever its user lives, and its Python is Debian's.
    ::setenv("ROS_HOME", folder_.c_str(), 1);
    ::setenv("ROS_MASTER_URI", ("http://" + address_of_host(1) + ":11311").c_str(), 1);
    ::setenv("ROS_IP", address_of_host(1).c_str(), 1);
    daemons_ = infrastructure_of(contestant_, programs_, folder_);
    running_.resize(daemons_.size());
}

void World::start(std::size_t daemon) {
    const Daemon& what = daemons_[daemon];
    const Lan::On there(lan_, what.host);
    running_[daemon] = std::make_unique<BrokerProcess>(what.name, what.program, what.arguments,
                                                       folder_ / (what.name + ".txt"));
}

void World::start_infrastructure() {
    for (std::size_t daemon = 0; daemon < daemons_.size(); ++daemon) start(daemon);
}

void World::await_infrastructure() {
    if (daemons_.empty()) return;
    const auto serves = [this] {
        if (contestant_.system != System::romano) {
            const Lan::On there(lan_, 1);
            return accepts_tcp(address_of_host(1),
                               contestant_.system == System::ros1 ? 11'311 : 1883);
        }
        const std::string whole_view = " of " + std::to_string(contestant_.brokers) + ", led by ";
        for (const Daemon& daemon : daemons_) {
            const std::string said = text_of(folder_ / (daemon.name + ".txt"));
            if (contestant_.brokers == 1 ? said.empty()
                                         : said.find(whole_view) == std::string::npos) {
                return false;
            }
        }
        return true;
    };
    const Instant deadline = net::now() + patience;
    while (!serves()) {
        check();
        if (net::now() > deadline) {
            throw std::runtime_error("the infrastructure of " + contestant_.name +
                                     " does not begin to serve");
        }
        std::this_thread::sleep_for(look_every);
    }
}

void World::kill_first_daemon() {
    running_.at(0).reset();
}

void World::start_first_daemon() {
    start(0);
}

int World::host_of_node(int number) const {
    return contestant_.brokers + 1 + number;
}

fs::path World::file_of(int number, const char* what) const {
    return folder_ / ("node" + std::to_string(number) + what);
}

Instant World::start_node(int number, const NodeTask& task) {
    const int host = host_of_node(number);
    std::vector<std::string> arguments{"--name",    task.name,
                                       "--address", address_of_host(host),
                                       "--number",  std::to_string(number),
                                       "--octets",  std::to_string(task.octets),
                                       "--rate",    std::to_string(task.rate_per_s),
                                       "--samples", file_of(number, ".samples").string()};
    const auto add = [&arguments](const char* option, const std::string& value) {
        arguments.emplace_back(option);
        arguments.push_back(value);
    };
    if (const auto address = infrastructure_address(contestant_, number)) {
        add("--infrastructure", *address);
    }
    if (task.publishes) add("--publish", *task.publishes);
    for (const std::string& topic : task.subscribes) add("--subscribe", topic);
    if (task.echo) arguments.emplace_back("--echo");
    if (!contestant_.reliable) arguments.emplace_back("--best-effort");
    const Lan::On there(lan_, host);
    auto& node = nodes_.at(static_cast<std::size_t>(number));
    node.reset();
    const Instant started = net::now();
    node = std::make_unique<BrokerProcess>(task.name, node_program(contestant_, programs_),
                                           arguments, file_of(number, ".txt"));
    return started;
}

void World::kill_node(int number) {
    nodes_.at(static_cast<std::size_t>(number)).reset();
}

std::optional<Instant> World::first_heard(int number) const {
    std::istringstream said(text_of(file_of(number, ".txt")));
    for (std::string line; std::getline(said, line);) {
        std::istringstream words(line);
        std::string word;
        std::int64_t ns = 0;
        if (words >> word >> ns && word == "first") return Instant{Duration{ns}};
    }
    return std::nullopt;
}

void World::check() const {
    if (interrupted != 0) throw std::runtime_error("interrupted");
    for (const auto* processes : {&running_, &nodes_}) {
        for (const auto& process : *processes) {
            if (process) process->expect_running();
        }
    }
}

void World::await_first(const std::vector<int>& numbers) {
    for (const int number : numbers) {
        if (await_first(number, patience)) continue;
        throw std::runtime_error("node " + std::to_string(number) + " of " +
                                 contestant_.full_name() + " hears nothing");
    }
}

bool World::await_first(int number, Duration time) {
    const Instant deadline = net::now() + time;
    while (!first_heard(number)) {
        check();
        if (net::now() > deadline) return false;
        (void)tap_.take();
        std::this_thread::sleep_for(look_every);
    }
    return true;
}

std::vector<Packet> World::run(Duration time) {
    const Instant end = net::now() + time;
    (void)tap_.lost();
    std::vector<Packet> packets;
    while (net::now() < end) {
        std::this_thread::sleep_for(std::min<Duration>(look_every, end - net::now()));
        const auto more = tap_.take();
        packets.insert(packets.end(), more.begin(), more.end());
        check();
    }
    if (tap_.lost() > 0) throw std::runtime_error("more packets than could be counted");
    return packets;
}

void World::stop_nodes() {
    for (const auto& node : nodes_) {
        if (node) node->ask_to_stop();
    }
    for (auto& node : nodes_) {
        if (node) node->stop(std::chrono::duration_cast<std::chrono::milliseconds>(farewell));
        node.reset();
    }
}

std::vector<Sample> World::samples_of(int number) const {
    return read_samples(file_of(number, ".samples"));
}

Usage World::infrastructure_usage() const {
    return usage_of(running_);
}

Usage World::node_usage() const {
    return usage_of(nodes_);
}

Usage World::usage_of_node(int number) const {
    const auto& node = nodes_.at(static_cast<std::size_t>(number));
    Usage usage;
    if (!node) return usage;
    usage.cpu_s = cpu_s_of(node->pid());
    if (const auto used = experiments::usage_of(node->pid())) usage.rss_mib = used->rss_mib;
    return usage;
}

}  // namespace romano::bench::ros
