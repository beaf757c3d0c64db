// What a broker says about a broker: the JSON text that it keeps retained on $SYS/brokers/<name>.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace romano::experiments {

/// Clients subscribe to this to learn of every broker that theirs knows.
inline constexpr std::string_view brokers_filter = "$SYS/brokers/+";

struct BrokerStatus {
    std::string name;
    bool alive = false;
    bool leader = false;
    std::uint64_t rank = 0;
    std::optional<std::uint64_t> condition;  // battery or load, from 0 (spent) to 100
    std::uint64_t sessions = 0;
    std::uint64_t connected = 0;
    std::vector<std::string> addresses;  // "127.0.0.1:1883"
    std::uint64_t cannot_take = 0;       // so many of its peers' addresses, were they to die
    std::uint64_t incarnation = 0;       // higher at each start
    std::uint64_t view_term = 0;
    std::string view_leader;
    std::string rights;  // their digest; empty: it is not known
    std::vector<std::string> view_members;
    std::uint64_t transport_octets_sent = 0;   // to its peers, since it started
    std::uint64_t longest_turn_us = 0;         // of the last half minute to minute
    std::optional<std::uint64_t> cpu_percent;  // of a core, in the last five seconds
    std::vector<std::string> does_not_hear;    // living members of the view
    /// Settings that must agree and do not: the values by broker's name, by setting.
    std::map<std::string, std::map<std::string, std::string>> disagrees;
};

/// Empty when the text is no such JSON object with a name; other keys that lack keep their
/// defaults, and unknown ones are passed over: brokers of several versions may meet.
[[nodiscard]] std::optional<BrokerStatus> parse_broker_status(std::string_view json);

}  // namespace romano::experiments
