#include "experiments/process/lan.h"

#include <fcntl.h>
#include <sched.h>
#include <unistd.h>

#include <cassert>
#include <cerrno>
#include <iterator>
#include <sstream>
#include <system_error>

#include "experiments/process/program.h"

namespace romano::experiments {
namespace {

/// `ip` with these words. None of them has a space.
ProgramEnd ip(const std::string& words) {
    std::istringstream stream(words);
    return run_program("ip", {std::istream_iterator<std::string>(stream), {}});
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
    if (!run("netns add " + name(0)) || !run("-n " + name(0) + " link add lan type bridge") ||
        !run("-n " + name(0) + " link set lan up")) {
        return;
    }
    for (int host = 1; host <= hosts; ++host) {
        const std::string n = std::to_string(host);
        const std::string in = "-n " + name(host) + " ";
        const bool done =
            run("netns add " + name(host)) &&
            run(in + "link add eth0 type veth peer name port" + n + " netns " + name(0)) &&
            run("-n " + name(0) + " link set port" + n + " master lan up") &&
            run(in + "link set lo up") && run(in + "link set eth0 up") &&
            run(in + "address add 10.60.0." + n + "/24 dev eth0") &&
            run(in + "address add fd60::" + n + "/64 dev eth0 nodad");
        if (!done) return;
    }
}

Lan::~Lan() {
    for (int host = 0; host <= hosts_ + (has_cells_ ? 1 : 0); ++host) {
        (void)ip("netns del " + name(host));
    }
}

// The cells are bridges beside the LAN's, in host 0.
void Lan::add_cells(int cells) {
    if (!why_not_.empty()) return;
    const std::string air = "-n " + name(0) + " ";
    const int rover = hosts_ + 1;
    has_cells_ = true;
    for (int cell = 1; cell <= cells; ++cell) {
        const std::string n = std::to_string(cell);
        const std::string in = "-n " + name(cell) + " ";
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
    const std::string in = "-n " + name(rover) + " ";
    (void)(run("netns add " + name(rover)) &&
           run(in + "link add eth0 type veth peer name rover netns " + name(0)) &&
           run(air + "link set rover master cell1 up") && run(in + "link set lo up") &&
           run(in + "link set eth0 up") &&
           run(in + "address add " + rover_address + "/24 dev eth0"));
}

void Lan::drive_to(int cell) {
    (void)run("-n " + name(0) + " link set rover master cell" + std::to_string(cell));
}

std::string Lan::name(int host) const {
    return prefix_ + std::to_string(host);
}

bool Lan::run(const std::string& words) {
    if (ip(words).ok()) return true;
    why_not_ = "no network namespaces here: `ip " + words + "` failed";
    return false;
}

std::string Lan::mac_of(int host) const {
    return after("link/ether", ip("-n " + name(host) + " link show dev eth0").output);
}

std::string Lan::neighbour(int host, const std::string& address) const {
    return after("lladdr", ip("-n " + name(host) + " neighbour show " + address).output);
}

bool Lan::has_address(int host, const std::string& address) const {
    const auto list = ip("-n " + name(host) + " -o address show dev eth0").output;
    return list.find(" " + address + "/") != std::string::npos;
}

void Lan::cut(int host) {
    run("-n " + name(0) + " link set port" + std::to_string(host) + " down");
}

void Lan::mend(int host) {
    run("-n " + name(0) + " link set port" + std::to_string(host) + " up");
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
