// What can befall the brokers of a cell while their robots go on talking.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace romano::experiments {

enum class Fault : std::uint8_t {
    none,
    kill_leader,      // kill -9 of the broker that leads
    kill_home,        // kill -9 of a broker that does not lead
    pause,            // SIGSTOP of such a broker, and SIGCONT after a while
    pause_leader,     // the same with the broker that leads
    cut,              // the network of such a broker's machine fails, and comes back after a while
    all_but_one,      // kill -9 of one after the other, until one is left
    rolling_restart,  // one after the other ends in order (SIGTERM) and is started again
    rolling_kill,     // the same with kill -9
};

[[nodiscard]] std::string_view name_of(Fault fault);
[[nodiscard]] std::optional<Fault> fault_named(std::string_view name);
/// "none, kill-leader, ...".
[[nodiscard]] std::string fault_names();

}  // namespace romano::experiments
