#include "experiments/process/lan.h"

#include <fcntl.h>
#include <sched.h>
#include <unistd.h>

#include <array>
#include <cassert>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <sstream>
#include <system_error>

namespace romano::experiments {
namespace {

std::string output_of(const std::string& command) {
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> pipe(popen(command.c_str(), "r"), pclose);
    std::string text;
    std::array<char, 4096> part{};
    while (pipe && std::fgets(part.data(), part.size(), pipe.get()) != nullptr) text += part.data();
    return text;
}

/// The word behind `word` in a line of words.
std::string after(const std::string& word, const std::string& line) {
    std::istringstream words(line);
    for (std::string each; words >> each;) {
        if (each == word && words >> each) return each;
    }
    return {};
}

}  // namespace

Lan::Lan(int hosts) : prefix_("romano" + std::to_string(getpid()) + "-"), hosts_(hosts) {
    if (geteuid() != 0) {
        why_not_ = "network namespaces need root";
        return;
    }
    // The bridge lives in a namespace too, so that nothing of it is seen outside: host 0.
    if (!run("ip netns add " + name(0)) || !run("ip -n " + name(0) + " link add lan type bridge") ||
        !run("ip -n " + name(0) + " link set lan up")) {
        return;
    }
    for (int host = 1; host <= hosts; ++host) {
        const std::string n = std::to_string(host);
        const std::string in = "ip -n " + name(host) + " ";
        const bool done =
            run("ip netns add " + name(host)) &&
            run(in + "link add eth0 type veth peer name port" + n + " netns " + name(0)) &&
            run("ip -n " + name(0) + " link set port" + n + " master lan up") &&
            run(in + "link set lo up") && run(in + "link set eth0 up") &&
            run(in + "address add 10.60.0." + n + "/24 dev eth0") &&
            run(in + "address add fd60::" + n + "/64 dev eth0 nodad");
        if (!done) return;
    }
}

Lan::~Lan() {
    for (int host = 0; host <= hosts_ + (has_cells_ ? 1 : 0); ++host) {
        (void)std::system(("ip netns del " + name(host) + " 2>/dev/null").c_str());
    }
}

// The cells are bridges beside the LAN's, in host 0.
void Lan::add_cells(int cells) {
    if (!why_not_.empty()) return;
    const std::string air = "ip -n " + name(0) + " ";
    const int rover = hosts_ + 1;
    has_cells_ = true;
    for (int cell = 1; cell <= cells; ++cell) {
        const std::string n = std::to_string(cell);
        const std::string in = "ip -n " + name(cell) + " ";
        const bool done =
            run(air + "link add cell" + n + " type bridge") &&
            run(air + "link set cell" + n + " up") &&
            run(in + "link add cell0 address 02:00:00:00:00:99 type veth peer name radio" + n +
                " netns " + name(0)) &&
            run(air + "link set radio" + n + " master cell" + n + " up") &&
            run(in + "link set cell0 up") &&
            run(in + "address add " + cell_address + "/24 dev cell0");
        if (!done) return;
    }
    const std::string in = "ip -n " + name(rover) + " ";
    (void)(run("ip netns add " + name(rover)) &&
           run(in + "link add eth0 type veth peer name rover netns " + name(0)) &&
           run(air + "link set rover master cell1 up") && run(in + "link set lo up") &&
           run(in + "link set eth0 up") &&
           run(in + "address add " + rover_address + "/24 dev eth0"));
}

void Lan::drive_to(int cell) {
    (void)run("ip -n " + name(0) + " link set rover master cell" + std::to_string(cell));
}

std::string Lan::name(int host) const {
    return prefix_ + std::to_string(host);
}

bool Lan::run(const std::string& command) {
    if (std::system((command + " 2>/dev/null").c_str()) == 0) return true;
    why_not_ = "no network namespaces here: `" + command + "` failed";
    return false;
}

std::string Lan::mac_of(int host) const {
    return after("link/ether", output_of("ip -n " + name(host) + " link show dev eth0"));
}

std::string Lan::neighbour(int host, const std::string& address) const {
    return after("lladdr", output_of("ip -n " + name(host) + " neighbour show " + address));
}

bool Lan::has_address(int host, const std::string& address) const {
    const auto list = output_of("ip -n " + name(host) + " -o address show dev eth0");
    return list.find(" " + address + "/") != std::string::npos;
}

void Lan::cut(int host) {
    run("ip -n " + name(0) + " link set port" + std::to_string(host) + " down");
}

void Lan::mend(int host) {
    run("ip -n " + name(0) + " link set port" + std::to_string(host) + " up");
}

Lan::On::On(const Lan& lan, int host)
    : home_(open("/proc/thread-self/ns/net", O_RDONLY | O_CLOEXEC)) {
    const int there = open(("/run/netns/" + lan.name(host)).c_str(), O_RDONLY | O_CLOEXEC);
    const bool is_there = setns(there, CLONE_NEWNET) == 0;
    const int reason = errno;
    close(there);
    if (is_there) return;
    close(home_);
    throw std::system_error(reason, std::generic_category(), "network namespace");
}

Lan::On::~On() {
    [[maybe_unused]] const int back = setns(home_, CLONE_NEWNET);
    assert(back == 0);
    close(home_);
}

}  // namespace romano::experiments
