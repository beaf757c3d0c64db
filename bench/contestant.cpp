#include "bench/contestant.h"

#include <sched.h>
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <limits>
#include <stdexcept>
#include <thread>
#include <utility>

#include "bench/mosquitto_clients.h"
#include "broker/net/endpoint_text.h"
#include "experiments/load/mqttsn_clients.h"

namespace romano::bench {
namespace {

using namespace std::chrono_literals;
namespace fs = std::filesystem;

fs::path own_folder() {
    return fs::read_symlink("/proc/self/exe").parent_path();
}

/// Files of this process, gone with it.
fs::path scratch(const std::string& name) {
    return fs::temp_directory_path() / ("romano-bench-" + std::to_string(::getpid()) + "-" + name);
}

std::vector<int> own_cores() {
    static const std::vector<int> cores = [] {
        std::vector<int> found;
        cpu_set_t set;
        if (::sched_getaffinity(0, sizeof set, &set) != 0) return found;
        for (int core = 0; core < CPU_SETSIZE; ++core) {
            if (CPU_ISSET(core, &set)) found.push_back(core);
        }
        return found;
    }();
    return cores;
}

void pin(pid_t process, std::size_t which) {
    if (own_cores().size() < 2) return;
    cpu_set_t set;
    CPU_ZERO(&set);
    CPU_SET(own_cores()[which], &set);
    (void)::sched_setaffinity(process, sizeof set, &set);
}

/// mosquitto as Debian ships it, without its files, and without limits that lose messages.
std::string mosquitto_configuration(const std::string& host, int port) {
    return "listener " + std::to_string(port) + " " + host +
           "\nallow_anonymous true\npersistence false\nlog_type error\nset_tcp_nodelay true\n"
           "max_queued_messages 0\nmax_inflight_messages 0\nuser root\n";
}

double field_kib(pid_t process, const std::string& file, const std::string& field) {
    std::ifstream fields("/proc/" + std::to_string(process) + "/" + file);
    for (std::string word; fields >> word;) {
        double kib = 0;
        if (word == field && fields >> kib) return kib;
    }
    return 0;
}

}  // namespace

void take_first_core() {
    (void)own_cores();  // as they are before
    pin(0, 0);
    (void)::setpriority(PRIO_PROCESS, 0, -20);
}

Contestant::Contestant(Entrant entrant, std::uint32_t clients) : entrant_(std::move(entrant)) {
    if (entrant_.kind == Kind::other) return;
    // A port of its own each time: nothing of an earlier run finds its way here.
    static int started = 0;
    host_ = "127.40." + std::to_string(::getpid() % 250) + ".1";
    port_ = 18'830 + started++ % 1000;
    const std::string address = host_ + ":" + std::to_string(port_);
    const fs::path trace = scratch("trace");
    fs::path program = own_folder() / "romano_reflector";
    std::vector<std::string> arguments{address};
    if (entrant_.kind == Kind::broker) {
        program = own_folder() / "romano-broker";
        arguments = {"--listen", scheme_of(entrant_.packets) + address, "--name", "bench"};
        if (entrant_.has_cell) arguments.insert(arguments.end(), {"--cell-group", cell_group()});
        if (entrant_.has_keys || entrant_.packets != Endpoint::Packets::plain) {
            fleet_.emplace(scratch("fleet"), std::vector<std::string>{"bench"}, clients);
            const auto with_keys = fleet_->broker_arguments("bench");
            arguments.insert(arguments.end(), with_keys.begin(), with_keys.end());
            if (entrant_.packets == Endpoint::Packets::plain) {  // their clients come there
                const std::string sealed = host_ + ":" + std::to_string(port_ + 1000);
                arguments.insert(arguments.end(), {"--listen", "protected://" + sealed});
            }
        }
    } else if (entrant_.kind == Kind::mosquitto) {
        std::ofstream(scratch("mosquitto.conf")) << mosquitto_configuration(host_, port_);
        program = "/usr/sbin/mosquitto";
        arguments = {"-c", scratch("mosquitto.conf").string()};
    }
    process_ =
        std::make_unique<experiments::BrokerProcess>(entrant_.name, program, arguments, trace);
    pin(process_->pid(), 1);
    // The two of ours say when they serve; mosquitto's clients try until it does.
    const auto deadline = std::chrono::steady_clock::now() + 20s;
    while (entrant_.kind != Kind::mosquitto && fs::file_size(trace) == 0) {
        check();
        if (std::chrono::steady_clock::now() > deadline) {
            throw std::runtime_error(entrant_.name + " does not begin to serve");
        }
        std::this_thread::sleep_for(2ms);
    }
}

Contestant::~Contestant() {
    process_.reset();
    std::error_code ignored;
    fs::remove(scratch("trace"), ignored);
    fs::remove(scratch("mosquitto.conf"), ignored);
    fs::remove_all(scratch("fleet"), ignored);
}

/// Of this run alone.
std::string Contestant::cell_group() const {
    return "239.40." + std::to_string(::getpid() % 250) + ".1:" + std::to_string(port_);
}

std::unique_ptr<experiments::LoadClients> Contestant::clients(
    const experiments::LoadPlan& plan, experiments::SocketUse sockets) const {
    if (entrant_.kind == Kind::mosquitto) {
        return std::make_unique<MosquittoClients>(plan, host_, port_);
    }
    experiments::MqttsnOptions options{
        .brokers = {entrant_.address ? *entrant_.address
                                     : *net::parse_endpoint(host_ + ":" + std::to_string(port_))},
        .sockets = sockets,
        .timing = {.t_retry = 500ms, .t_wait = 500ms, .n_retry = 20}};
    if (entrant_.has_cell) options.cell_group = *net::parse_endpoint(cell_group());
    if (entrant_.packets != Endpoint::Packets::plain) {
        options.keyed = [this](std::uint32_t client, keys::ClientSpeech::Put put) {
            return fleet_->client(client, entrant_.packets, std::move(put));
        };
    }
    return std::make_unique<experiments::MqttsnClients>(plan, options);
}

double Contestant::cpu_s() const {
    if (process_ == nullptr) return std::numeric_limits<double>::quiet_NaN();
    std::ifstream stat("/proc/" + std::to_string(process_->pid()) + "/schedstat");
    double ns = 0;  // of its one thread
    stat >> ns;
    return ns * 1e-9;
}

Memory Contestant::memory() const {
    if (process_ == nullptr) return {};
    const pid_t pid = process_->pid();
    return {.resident_kib = field_kib(pid, "status", "VmRSS:"),
            .proportional_kib = field_kib(pid, "smaps_rollup", "Pss:"),
            .anonymous_kib = field_kib(pid, "status", "RssAnon:")};
}

void Contestant::check() {
    if (process_ == nullptr || !process_->has_ended()) return;
    throw std::runtime_error(entrant_.name + " ended: " + process_->how_it_ended());
}

}  // namespace romano::bench
