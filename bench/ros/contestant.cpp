#include "bench/ros/contestant.h"

#include <fstream>

namespace romano::bench::ros {
namespace {

namespace fs = std::filesystem;

constexpr const char* ros_master = "/usr/bin/rosmaster";
constexpr const char* ros_log = "/usr/lib/rosout/rosout";
constexpr const char* mosquitto = "/usr/sbin/mosquitto";

std::string program_name(System system) {
    switch (system) {
        case System::ros1:
            return "ros1";
        case System::cyclone:
            return "cyclone";
        case System::fastdds:
            return "fastdds";
        case System::mosquitto:
            return "mosquitto";
        case System::romano:
            break;
    }
    return "mqttsn";
}

/// As Debian ships it, without its files, and without bounds that lose messages.
fs::path mosquitto_configuration(const fs::path& folder) {
    const fs::path file = folder / "mosquitto.conf";
    std::ofstream(file) << "listener 1883 " << address_of_host(1)
                        << "\nallow_anonymous true\npersistence false\nlog_type error\n"
                           "set_tcp_nodelay true\nmax_queued_messages 0\nmax_inflight_messages 0\n"
                           "user root\n";
    return file;
}

}  // namespace

std::string Contestant::title() const {
    switch (system) {
        case System::ros1:
            return reliable ? "ROS 1, TCP" : "ROS 1, UDP";
        case System::cyclone:
            return std::string("ROS 2, Cyclone DDS, ") + (reliable ? "reliable" : "best effort");
        case System::fastdds:
            return std::string("ROS 2, Fast DDS, ") + (reliable ? "reliable" : "best effort");
        case System::mosquitto:
            return std::string("mosquitto, QoS ") + (reliable ? "1" : "0");
        case System::romano:
            break;
    }
    return "ROMANO, " + std::to_string(brokers) + (brokers == 1 ? " broker" : " brokers") +
           ", QoS " + (reliable ? "1" : "0");
}

std::vector<Contestant> all_contestants() {
    std::vector<Contestant> all;
    for (const bool reliable : {true, false}) {
        all.push_back({"ros1", System::ros1, 1, reliable});
        all.push_back({"ros2_cyclone", System::cyclone, 0, reliable});
        all.push_back({"ros2_fastdds", System::fastdds, 0, reliable});
        for (const int brokers : {1, 3, 5}) {
            all.push_back({"romano_" + std::to_string(brokers), System::romano, brokers, reliable});
        }
        all.push_back({"mosquitto", System::mosquitto, 1, reliable});
    }
    return all;
}

std::string what_is_missing(const Contestant& contestant, const fs::path& programs) {
    if (contestant.system == System::ros1) {
        if (!fs::exists(ros_master) || !fs::exists(ros_log)) {
            return "the packages python3-rosmaster and rosout are not installed";
        }
        if (!fs::exists(node_program(contestant, programs))) {
            return "this build was made without the packages libroscpp-dev and libstd-msgs-dev";
        }
    }
    if (contestant.system == System::mosquitto && !fs::exists(mosquitto)) {
        return "the package mosquitto is not installed";
    }
    for (const fs::path& program :
         {node_program(contestant, programs), programs / "romano-broker"}) {
        if (!fs::exists(program)) return "`" + program.string() + "` is not there: build it";
    }
    return {};
}

std::vector<Daemon> infrastructure_of(const Contestant& contestant, const fs::path& programs,
                                      const fs::path& folder) {
    std::vector<Daemon> daemons;
    switch (contestant.system) {
        case System::ros1:
            // What roscore starts, without the process that starts it.
            daemons.push_back(
                {"rosmaster", 1, "/usr/bin/python3", {ros_master, "--core", "-p", "11311"}});
            daemons.push_back({"rosout", 1, ros_log, {}});
            break;
        case System::mosquitto:
            daemons.push_back(
                {"mosquitto", 1, mosquitto, {"-c", mosquitto_configuration(folder).string()}});
            break;
        case System::romano:
            for (int host = 1; host <= contestant.brokers; ++host) {
                Daemon broker{"r" + std::to_string(host),
                              host,
                              programs / "romano-broker",
                              {"--listen", address_of_service(contestant, host) + ":1883",
                               "--allow-plain", "--name", "r" + std::to_string(host)}};
                if (contestant.brokers > 1) {
                    for (const char* word : {"--domain", "40", "--interface", "eth0", "--rank"}) {
                        broker.arguments.emplace_back(word);
                    }
                    // The last one leads, so that the first one's death is no leader's.
                    broker.arguments.push_back(std::to_string(host));
                }
                daemons.push_back(std::move(broker));
            }
            break;
        case System::cyclone:
        case System::fastdds:
            break;
    }
    return daemons;
}

fs::path node_program(const Contestant& contestant, const fs::path& programs) {
    return programs / ("romano_ros_node_" + program_name(contestant.system));
}

std::optional<std::string> infrastructure_address(const Contestant& contestant, int node) {
    if (contestant.brokers == 0) return std::nullopt;
    const int brokers = contestant.system == System::romano ? contestant.brokers : 1;
    const int host = 1 + node % brokers;
    return address_of_service(contestant, host);
}

std::string address_of_host(int host) {
    return "10.60.0." + std::to_string(host);
}

std::string address_of_service(const Contestant& contestant, int host) {
    const bool can_move = contestant.system == System::romano && contestant.brokers > 1;
    return address_of_host(can_move ? first_service + host : host);
}

}  // namespace romano::bench::ros
