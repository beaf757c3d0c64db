// What a run of the bench was asked for.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "romano/base/endpoint.h"

namespace romano::bench {

enum class Fault : std::uint8_t { crash, silence };
enum class Victim : std::uint8_t { leader, other };

struct Options {
    std::uint32_t trials = 100;
    std::uint32_t brokers = 3;
    Fault fault = Fault::crash;
    Victim victim = Victim::other;
    Endpoint::Packets packets = Endpoint::Packets::plain;  // of brokers and clients
    int qos = 1;
    std::uint32_t domain = 50;
    std::string network = "127.60.0";  // brokers serve .1, .2, ...
    std::uint16_t port = 11'883;
    std::uint16_t metrics_port = 0;  // of each broker's page of metrics; 0: there is none
    std::uint64_t seed = 1;
    std::filesystem::path output;          // a folder
    std::filesystem::path broker_program;  // romano-broker
    std::vector<std::string> broker_arguments;
    bool fresh = false;
    std::uint32_t at_most_s = 0;  // stop after so long, to be resumed; 0: no limit
    std::uint32_t watch_s = 0;    // under full load; 0: not
    std::uint32_t away_s = 0;     // the victim, in the middle of the watch; 0: there is no fault
    std::vector<std::uint32_t> timeouts_ms;  // trials and watch for each of these; empty: neither
};

[[nodiscard]] inline const char* name_of(Fault fault) {
    return fault == Fault::crash ? "crash" : "silence";
}
[[nodiscard]] inline const char* name_of(Endpoint::Packets packets) {
    switch (packets) {
        case Endpoint::Packets::sealed:
            return "protected";
        case Endpoint::Packets::dtls:
            return "dtls";
        case Endpoint::Packets::plain:
            break;
    }
    return "plain";
}
[[nodiscard]] inline const char* name_of(Victim victim) {
    return victim == Victim::leader ? "leader" : "other";
}

}  // namespace romano::bench
