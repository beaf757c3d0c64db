// Whom the comparison compares: what must run before nodes can meet, and which program a node is.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace romano::bench::ros {

enum class System { ros1, cyclone, fastdds, romano, mosquitto };

struct Contestant {
    std::string name;  // "romano_3"
    System system = System::romano;
    int brokers = 0;  // machines of master or brokers; none where nodes meet by themselves
    bool reliable = true;

    [[nodiscard]] std::string full_name() const { return name + (reliable ? "" : "_best_effort"); }
    /// For people: "ROS 1, TCP".
    [[nodiscard]] std::string title() const;
};

/// In the order of the report; each reliable, then each best effort.
[[nodiscard]] std::vector<Contestant> all_contestants();

/// One sentence on what is not installed or not built; empty when it can take part.
[[nodiscard]] std::string what_is_missing(const Contestant& contestant,
                                          const std::filesystem::path& programs);

/// A process of the infrastructure.
struct Daemon {
    std::string name;
    int host = 1;
    std::filesystem::path program;
    std::vector<std::string> arguments;
};

/// In the order in which they are started. `programs` holds ours, `folder` takes their files.
[[nodiscard]] std::vector<Daemon> infrastructure_of(const Contestant& contestant,
                                                    const std::filesystem::path& programs,
                                                    const std::filesystem::path& folder);

[[nodiscard]] std::filesystem::path node_program(const Contestant& contestant,
                                                 const std::filesystem::path& programs);
/// Of the master, or of the broker that this node is at: nodes take the brokers in turn.
[[nodiscard]] std::optional<std::string> infrastructure_address(const Contestant& contestant,
                                                                int node);
[[nodiscard]] std::string address_of_host(int host);
/// At which that host's broker serves. Where there are several it is no host's own, so that it can
/// move to another one.
[[nodiscard]] std::string address_of_service(const Contestant& contestant, int host);
inline constexpr int first_service = 200;  // the last number of such an address, less the host's

}  // namespace romano::bench::ros
