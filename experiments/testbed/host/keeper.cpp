#include "experiments/testbed/host/keeper.h"

#include <signal.h>
#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <csignal>
#include <fstream>
#include <functional>
#include <iterator>
#include <optional>
#include <thread>

#include "experiments/process/process_file.h"
#include "experiments/process/program.h"
#include "experiments/testbed/host/host_brokers.h"
#include "experiments/testbed/host/machine_claim.h"

namespace romano::experiments {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using nlohmann::json;

constexpr auto begins_within = 8s;
constexpr auto ends_within = 8s;
constexpr const char* ended_mark = "romano-host: it ended, ";  // in its log

std::string read(const fs::path& file) {
    std::ifstream stream(file);
    return {std::istreambuf_iterator<char>(stream), {}};
}

std::string last_line_of(const std::string& text) {
    const std::size_t end = text.find_last_not_of('\n');
    if (end == std::string::npos) return {};
    const std::size_t begin = text.find_last_of('\n', end);
    return text.substr(begin == std::string::npos ? 0 : begin + 1,
                       end - (begin == std::string::npos ? 0 : begin + 1) + 1);
}

/// Of the keeper in this folder, if it lives. Numbers of processes are used again: it must be one.
pid_t keeper_in(const fs::path& folder) {
    const int pid = std::atoi(read(folder / "keeper.pid").c_str());
    if (pid <= 1) return 0;
    const std::string command = process_file(pid, "cmdline");
    const bool is_keeper = command.find("romano-host") != std::string::npos &&
                           command.find(folder.string()) != std::string::npos;
    return is_keeper ? pid : 0;
}

bool within(std::chrono::seconds time, const std::function<bool()>& done) {
    const auto deadline = std::chrono::steady_clock::now() + time;
    while (!done()) {
        if (std::chrono::steady_clock::now() > deadline) return false;
        std::this_thread::sleep_for(20ms);
    }
    return true;
}

std::optional<KeptPrograms> order_in(const fs::path& folder) {
    try {
        return json::parse(read(folder / "kept.json")).get<KeptPrograms>();
    } catch (const json::exception&) {
        return std::nullopt;
    }
}

/// What is run in the background must not be a child that waits for us, nor hold the connection.
constexpr const char* in_background =
    "setsid \"$0\" keep \"$1\" </dev/null >\"$1/keeper.txt\" 2>&1 &";

}  // namespace

json keep_running(const KeptPrograms& order, const fs::path& programs) {
    const fs::path folder = order.folder;
    if (const std::string who = who_has_the_machine(); !who.empty()) {
        return {{"kept", false}, {"trouble", "it is taken by " + who}};
    }
    std::error_code error;
    fs::create_directories(folder / "logs", error);
    fs::remove(folder / "keeper.pid", error);
    std::ofstream(folder / "kept.json") << json(order).dump(1) << '\n';
    if (read(folder / "kept.json").empty()) {
        return {{"kept", false}, {"trouble", "cannot write in `" + order.folder + "`"}};
    }
    (void)run_program("/bin/sh",
                      {"-c", in_background, (programs / "romano-host").string(), order.folder});
    if (within(begins_within, [&] { return keeper_in(folder) != 0; })) return {{"kept", true}};
    return {{"kept", false},
            {"trouble", "the keeper did not begin: " + last_line_of(read(folder / "keeper.txt"))}};
}

json what_is_kept(const fs::path& folder) {
    json programs = json::array();
    const json kept = json::parse(read(folder / "kept.json"), nullptr, false);
    if (!kept.is_discarded()) {
        for (const ProgramOrder& order : kept.get<KeptPrograms>().programs) {
            const std::string log = read(folder / "logs" / order.trace);
            programs.push_back({{"name", order.name},
                                {"serves", log.find(": serving ") != std::string::npos},
                                {"has_ended", last_line_of(log).starts_with(ended_mark)},
                                {"said", last_line_of(log)}});
        }
    }
    return {{"kept", keeper_in(folder) != 0}, {"programs", programs}};
}

json end_keeping(const fs::path& folder) {
    const pid_t keeper = keeper_in(folder);
    if (keeper == 0) return {{"kept", false}, {"was", false}};
    ::kill(keeper, SIGTERM);
    if (!within(ends_within, [&] { return keeper_in(folder) == 0; })) {
        return {{"kept", true},
                {"trouble", "the keeper, process " + std::to_string(keeper) + ", does not end"}};
    }
    return {{"kept", false}, {"was", true}};
}

int keep(const fs::path& folder, const fs::path& programs) {
    const auto order = order_in(folder);
    if (!order) {
        std::fprintf(stderr, "romano-host: %s: must be what `romano testbed start` wrote there\n",
                     (folder / "kept.json").c_str());
        return 2;
    }
    const auto claim = MachineClaim::take(Holder::keeper);
    if (!claim) {
        std::fprintf(stderr, "romano-host: the machine is taken by %s\n",
                     who_has_the_machine().c_str());
        return 2;
    }
    boost::asio::io_context io{1};
    boost::asio::signal_set signals(io, SIGTERM, SIGINT, SIGHUP);
    signals.async_wait([&io](const auto&, int) { io.stop(); });
    HostBrokers brokers{programs, folder / "logs", order->addresses};
    for (const ProgramOrder& each : order->programs) brokers.start(each);
    std::ofstream(folder / "keeper.pid") << ::getpid() << '\n';
    boost::asio::steady_timer timer(io);
    const std::function<void()> look = [&] {
        for (const auto& [number, life, how] : brokers.look()) {
            std::ofstream(folder / "logs" / order->programs.at(number).trace, std::ios::app)
                << ended_mark << how << '\n';
        }
        brokers.renew_leases();
        timer.expires_after(1s);
        timer.async_wait([&](const auto& error) {
            if (!error) look();
        });
    };
    look();
    io.run();
    brokers.stop_all();
    std::error_code ignored;
    fs::remove(folder / "keeper.pid", ignored);
    return 0;
}

}  // namespace romano::experiments
