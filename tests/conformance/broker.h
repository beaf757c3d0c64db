// The broker under test: a romano-broker process of this run, or any broker at an address.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "romano/base/endpoint.h"

namespace romano::system {
class Process;
}

namespace romano::conformance {

/// What is agreed on beforehand with the broker under test.
struct Agreement {
    std::optional<Endpoint> address;  // of a broker that runs already; none: our own processes
    std::uint16_t predefined_id = 7;
    std::string predefined_topic = "conformance/predefined";
    std::chrono::milliseconds quiet{0};  // how long to listen until "nothing came" is true
};
Agreement& agreement();

/// Which broker a case needs.
enum class Kind {
    patient,    // Tretry is longer than any case: no repetition comes between
    impatient,  // Tretry is short: for cases about repetitions
    narrow,     // its tables hold little: for cases about "congestion"
};

struct Narrow {  // the limits of Kind::narrow
    static constexpr std::size_t sessions = 6;
    static constexpr std::size_t session_expiry_s = 1;
    static constexpr std::size_t connecting = 2;
    static constexpr std::size_t subscriptions = 2;
    static constexpr std::size_t topics = 3;
    static constexpr std::size_t queued = 3;
    static constexpr std::size_t retained = 2;
    static constexpr std::size_t unreleased = 2;
    static constexpr std::size_t payload_octets = 100;
    static constexpr std::size_t client_id_octets = 23;
};

/// Its address in that family; started with the first case that needs it. Empty when the broker
/// under test is not ours and has no such address or kind.
[[nodiscard]] std::optional<Endpoint> broker_at(Kind kind, Endpoint::Family family);

}  // namespace romano::conformance
