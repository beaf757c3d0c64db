// romano-robot: one simulated ROMANO robot, or hundreds for a load.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>
#include <stdexcept>

#include "broker/net/clock.h"
#include "broker/net/endpoint_text.h"
#include "broker/net/service_manager.h"
#include "broker/net/socket_address.h"
#include "firmware/posix/simulated_robot.h"
#include "firmware/robot/address.h"
#include "romano/cli/real_number.h"
#include "romano/keys/client_keys.h"
#include "romano/keys/key_error.h"

namespace {

using namespace romano;
using firmware::SimulatedRobot;
using firmware::SimulatedRobotOptions;

constexpr const char* examples = R"(Examples:
  romano-robot --id abcd1234 --broker 127.0.0.1:1883
      one robot at that broker; `romano move abcd1234 front 100mm` moves it
  romano-robot --discover --local 192.168.1.20
      finds the nearest broker by itself, by that address's interface (brokers: --discovery-group default)
  romano-robot --count 20 --broker 127.0.0.1:1883 --telemetry 'robots/{id}/pose' --heartbeat 2   (as romano web shows them)
  romano-robot --broker 127.0.0.1:1883 --telemetry line --every 0.5 --heartbeat 2 --keep-session
      tells where it is twice a second, and is missed when its heartbeats are
  romano-robot --count 300 --id 00000001 --broker 127.0.0.1:1883 --broker 127.0.0.2:1883 --quiet
      300 robots, dealt to two brokers in turn; Ctrl-C prints what became of them
  romano-robot --key abcd1234.key --broker 127.0.0.1:1883
      robot abcd1234 at a protected:// address of that broker (romano keys new); with --dtls, at a dtls:// one

Each line of output is a robot's id and what happened; with --json it is a JSON object.
Exit code: 0 at the end (Ctrl-C, --seconds), 2 when a setting is not possible.)";

/// A robot that has no broker after so long has none for a reason.
constexpr std::chrono::seconds patience{5};

struct Settings {
    std::string id;
    std::string key;
    bool speaks_dtls = false;
    std::vector<std::string> brokers;
    bool discovers = false;
    std::string local;
    std::string group;
    std::string cell_group;
    unsigned count = 1;
    std::string telemetry;
    double every_s = 1;
    double heartbeat_s = 0;
    unsigned keep_alive_s = 30;
    bool keep_session = false;
    std::vector<std::string> subscriptions;
    std::string follow;
    double seconds = 0;
    bool quiet = false;
    bool as_json = false;
};

void add_options(CLI::App& app, Settings& to) {
    app.add_option("--id", to.id, "ROMANO id, 8 lower-case hexadecimal digits (default: made up)");
    app.add_option("--key", to.key,
                   "Own key, for a broker with protected:// addresses; or the folder with the "
                   "robots' keys, ID.key (romano keys new)")
        ->type_name("FILE|DIR");
    app.add_flag("--dtls", to.speaks_dtls,
                 "Speak DTLS 1.2 with the key, for a broker with dtls:// addresses")
        ->needs("--key");
    app.add_option("--broker", to.brokers, "The broker (repeatable: robots are dealt in turn)")
        ->type_name("ADDR:PORT");
    app.add_flag("--discover", to.discovers, "Find the nearest broker instead");
    app.add_option(
           "--local", to.local,
           "Own IP address; its family is spoken, :: for IPv6 (default: the system's choice, "
           "of the family of --broker or --group, else IPv4)")
        ->type_name("ADDR");
    app.add_option("--group", to.group,
                   "Where discovery asks (default: 225.1.1.1:1883 or [ff02::225:1:1:1]:1883)")
        ->needs("--discover")
        ->type_name("ADDR:PORT");
    app.add_option("--cell-group", to.cell_group,
                   "Listen to this multicast group, too, for what the broker sends once for many "
                   "(its --cell-group); not with --key")
        ->type_name("ADDR:PORT");
    app.add_option("--count", to.count, "So many robots, with ids from --id on")
        ->check(CLI::Range(1U, 10'000U))
        ->capture_default_str();
    app.add_option("--telemetry", to.telemetry,
                   "Publish the own location on this topic; {id} in it is the robot's id")
        ->type_name("TOPIC");
    app.add_option("--every", to.every_s, "Seconds between two locations")
        ->needs("--telemetry")
        ->check(real_number(0.001, 3600))
        ->capture_default_str();
    app.add_option("--heartbeat", to.heartbeat_s, "Seconds between two heartbeats, 0 for none")
        ->check(real_number(0, 3600))
        ->capture_default_str();
    app.add_option("--keepalive", to.keep_alive_s, "Keep-alive in seconds")
        ->check(CLI::Range(1U, 65'535U))
        ->capture_default_str();
    app.add_flag("--keep-session", to.keep_session,
                 "The broker keeps messages while the robot is away");
    app.add_option("--subscribe", to.subscriptions, "Subscribe to this topic too (repeatable)")
        ->type_name("TOPIC");
    app.add_option("--follow", to.follow, "Copy the path of the locations that come on this topic")
        ->type_name("TOPIC");
    app.add_option("--seconds", to.seconds, "End after so long (default: never)")
        ->check(real_number(0, 1e6));
    app.add_flag("--quiet", to.quiet, "Print nothing but the summary at the end");
    app.add_flag("--json", to.as_json, "Print JSON objects, one a line");
}

[[noreturn]] void refuse(const std::string& sentence) {
    throw std::invalid_argument(sentence);
}

Endpoint parse_address(const std::string& option, const std::string& text) {
    const auto endpoint = net::parse_endpoint(text);
    if (!endpoint || endpoint->port == 0) {
        refuse("--" + option + " '" + text +
               "': is no address and port; write ADDR:PORT, for example 127.0.0.1:1883 or "
               "[::1]:1883");
    }
    return *endpoint;
}

bool is_one_key(const Settings& settings) {
    return !settings.key.empty() && !std::filesystem::is_directory(settings.key);
}

/// Of the robots that are asked for the last one must have an id, too.
void check_room_for_ids(const Settings& settings, std::uint32_t first) {
    const std::uint32_t behind = std::numeric_limits<std::uint32_t>::max() - first;
    if (settings.count - 1 <= behind) return;
    refuse("--count '" + std::to_string(settings.count) + "': from --id " + settings.id +
           " on there are " + std::to_string(behind + 1) + " ids; the last one is ffffffff");
}

std::uint32_t first_id(const Settings& settings) {
    std::string text = settings.id;
    const bool is_of_key = text.empty() && is_one_key(settings);
    if (is_of_key) text = keys::read_own_key(settings.key).name;
    if (text.empty()) return std::random_device{}();
    if (!message::RomanoId::parse(text)) {
        const std::string given = is_of_key
                                      ? "--key '" + settings.key + "': its name '" + text + "'"
                                      : "--id '" + text + "':";
        refuse(given + " must be 8 lower-case hexadecimal digits, for example abcd1234");
    }
    const auto first = static_cast<std::uint32_t>(std::stoul(text, nullptr, 16));
    check_room_for_ids(settings, first);
    return first;
}

message::RomanoId id_of(std::uint32_t number) {
    char digits[9];
    std::snprintf(digits, sizeof digits, "%08x", number);
    return *message::RomanoId::parse(digits);
}

std::filesystem::path key_of(const Settings& settings, const message::RomanoId& id) {
    if (settings.key.empty() || is_one_key(settings)) return settings.key;
    return std::filesystem::path{settings.key} / (std::string{id.text()} + ".key");
}

/// `robots/{id}/pose` of that robot.
std::string topic_of(std::string pattern, const message::RomanoId& id) {
    constexpr std::string_view place = "{id}";
    const auto at = pattern.find(place);
    return at == std::string::npos ? pattern : pattern.replace(at, place.size(), id.text());
}

Duration seconds(double value) {
    return std::chrono::duration_cast<Duration>(std::chrono::duration<double>{value});
}

void check_cell_group(const Settings& settings, SimulatedRobotOptions& options) {
    if (settings.cell_group.empty()) return;
    const Endpoint group = parse_address("cell-group", settings.cell_group);
    const auto refuse_it = [&](const std::string& why) {
        refuse("--cell-group '" + settings.cell_group + "': " + why);
    };
    if (!net::is_multicast(group)) {
        refuse_it("is no multicast group; write the broker's, for example 239.18.83.1:1884");
    }
    if (!settings.key.empty()) {
        refuse_it("is not for robots with a --key: what a group hears is not protected");
    }
    options.cell_group = firmware::address_of(group);
    const auto is_other = [&](const std::string& text) {
        return parse_address("broker", text).family != group.family;
    };
    const bool is_of_other_family = options.local.family != 0
                                        ? options.local.family != options.cell_group.family
                                        : std::ranges::any_of(settings.brokers, is_other);
    if (is_of_other_family || (settings.discovers && options.local.family == 0 &&
                               group.family == Endpoint::Family::ipv6)) {
        refuse_it(
            "is not of the family that is spoken (--local, --broker); give both of IPv4, or "
            "both of IPv6");
    }
    options.robot.node.listens_to_cell = true;
}

SimulatedRobotOptions check(const Settings& settings) {
    if (settings.discovers == !settings.brokers.empty()) {
        refuse("--broker or --discover: give one of them; --help shows examples");
    }
    if (settings.count > 1 && is_one_key(settings)) {
        refuse("--key '" + settings.key +
               "': is one robot's key; for --count give the folder with all robots' keys");
    }
    SimulatedRobotOptions options;
    if (!settings.local.empty() && !romano_udp_address(settings.local.c_str(), 0, &options.local)) {
        refuse("--local '" + settings.local + "': is no IP address");
    }
    if (!settings.group.empty()) {
        const Endpoint group = parse_address("group", settings.group);
        if (!net::is_multicast(group)) {
            refuse("--group '" + settings.group +
                   "': is no multicast group; for example 225.1.1.1:1883");
        }
        options.group = firmware::address_of(group);
        if (settings.local.empty()) options.local.family = options.group.family;
    }
    if (options.group.family != 0 && options.local.family != 0 &&
        options.group.family != options.local.family) {
        refuse("--group '" + settings.group + "': is not of the family of --local '" +
               settings.local + "'; give both of IPv4, or both of IPv6");
    }
    check_cell_group(settings, options);
    options.robot.node.keep_alive = std::chrono::seconds{settings.keep_alive_s};
    options.robot.node.heartbeat_every = seconds(settings.heartbeat_s);
    options.robot.node.keep_session = settings.keep_session;
    options.robot.timing.t_retry = std::chrono::seconds{1};
    options.telemetry_every = seconds(settings.every_s);
    options.subscriptions = settings.subscriptions;
    options.follow = settings.follow;
    return options;
}

std::vector<Endpoint> check_brokers(const Settings& settings, const romano_address& local) {
    std::vector<Endpoint> out;
    for (const std::string& text : settings.brokers) {
        out.push_back(parse_address("broker", text));
        if (local.family != 0 && firmware::address_of(out.back()).family != local.family) {
            refuse("--broker '" + text + "': is not of the family of --local '" + settings.local +
                   "'; give both of IPv4, or both of IPv6");
        }
    }
    return out;
}

void say(const Settings& settings, const message::RomanoId& id, const std::string& what) {
    if (settings.quiet) return;
    if (!settings.as_json) {
        std::printf("%s %s\n", std::string{id.text()}.c_str(), what.c_str());
    } else {
        const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(net::unix_time());
        const nlohmann::ordered_json line{
            {"unix_ms", ms.count()}, {"robot", id.text()}, {"what", what}};
        using nlohmann::json;
        std::puts(line.dump(-1, ' ', false, json::error_handler_t::replace).c_str());
    }
    std::fflush(stdout);
}

void sum_up(const Settings& settings, const std::vector<std::unique_ptr<SimulatedRobot>>& robots) {
    std::uint64_t established = 0;
    std::uint64_t lost = 0;
    firmware::RobotCounters sum;
    for (const auto& robot : robots) {
        established += robot->core().node().phase() == node::Phase::established ? 1U : 0U;
        lost += robot->core().node().counters().connections_lost;
        sum.commands += robot->counters().commands;
        sum.messages += robot->counters().messages;
        sum.telemetry += robot->counters().telemetry;
    }
    if (settings.as_json) {
        std::puts(nlohmann::ordered_json{{"robots", robots.size()},
                                         {"established", established},
                                         {"connections_lost", lost},
                                         {"commands", sum.commands},
                                         {"messages", sum.messages},
                                         {"locations_published", sum.telemetry}}
                      .dump()
                      .c_str());
    } else {
        std::printf(
            "%zu robots, %llu established, %llu connections lost; %llu commands, %llu other "
            "messages; %llu locations published\n",
            robots.size(), static_cast<unsigned long long>(established),
            static_cast<unsigned long long>(lost), static_cast<unsigned long long>(sum.commands),
            static_cast<unsigned long long>(sum.messages),
            static_cast<unsigned long long>(sum.telemetry));
    }
    std::fflush(stdout);
}

/// Who starts robots learns that some have no broker yet, and what to look at.
void tell_of_robots_without_broker(const Settings& settings,
                                   const std::vector<std::unique_ptr<SimulatedRobot>>& robots) {
    const auto waiting = std::ranges::count_if(robots, [](const auto& robot) {
        return robot->core().node().phase() != node::Phase::established;
    });
    if (waiting == 0) return;
    std::fprintf(
        stderr, "romano-robot: %s no broker within %lld s; %s\n",
        robots.size() == 1 ? "the robot has found"
                           : (std::to_string(waiting) + " of " + std::to_string(robots.size()) +
                              " robots have found")
                                 .c_str(),
        static_cast<long long>(patience.count()),
        settings.discovers
            ? "is a broker there that answers discovery (--discovery-group default), at an "
              "address that this machine reaches (--listen), on the network of --local?"
            : "does a broker answer at --broker (romano brokers -h ADDR -p PORT)?");
}

/// So that they are known to be gone at once, and not when their keep-alive ends.
void leave(boost::asio::io_context& io,
           const std::vector<std::unique_ptr<SimulatedRobot>>& robots) {
    std::size_t here = robots.size();
    for (const auto& robot : robots) robot->leave([&here] { --here; });
    io.restart();
    while (here > 0) io.run_one();
}

void run(const Settings& settings) {
    SimulatedRobotOptions options = check(settings);
    const std::vector<Endpoint> brokers = check_brokers(settings, options.local);
    const std::uint32_t first = first_id(settings);
    options.telemetry_topic = topic_of(settings.telemetry, id_of(first));
    firmware::check_topics(options);
    boost::asio::io_context io{1};
    boost::asio::signal_set signals(io, SIGTERM, SIGINT);
    net::ServiceManager manager(io);
    signals.async_wait([&](const auto&, int) {
        manager.ending();
        io.stop();
    });
    std::vector<std::unique_ptr<SimulatedRobot>> robots;
    for (unsigned i = 0; i < settings.count; ++i) {
        options.robot.node.id = id_of(first + i);
        options.robot.seed = first + i;
        options.key_file = key_of(settings, options.robot.node.id);
        if (settings.speaks_dtls) options.speech = keys::Speech::dtls;
        options.telemetry_topic = topic_of(settings.telemetry, options.robot.node.id);
        if (!brokers.empty()) options.robot.broker = brokers[i % brokers.size()];
        robots.push_back(std::make_unique<SimulatedRobot>(
            io, options,
            [&](const auto& id, const std::string& what) { say(settings, id, what); }));
    }
    manager.serving(std::to_string(robots.size()) + " robots");
    boost::asio::steady_timer told(io, patience);
    told.async_wait([&](const auto& cancelled) {
        if (!cancelled) tell_of_robots_without_broker(settings, robots);
    });
    if (settings.seconds > 0) {
        io.run_for(
            std::chrono::duration_cast<std::chrono::milliseconds>(seconds(settings.seconds)));
    } else {
        io.run();
    }
    sum_up(settings, robots);
    told.cancel();
    leave(io, robots);
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app{
        "A simulated ROMANO robot over MQTT-SN: it carries commands out at once and prints "
        "them.",
        "romano-robot"};
    app.footer(examples);
    app.get_formatter()->column_width(34);
    Settings settings;
    add_options(app, settings);
    try {
        app.parse(argc, argv);
        run(settings);
        return 0;
    } catch (const CLI::Success& asked) {
        return app.exit(asked);
    } catch (const keys::KeyError& error) {
        std::fprintf(stderr, "romano-robot: --key: %s\n", error.what());
        return 2;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "romano-robot: %s\n", error.what());
        return 2;
    }
}
