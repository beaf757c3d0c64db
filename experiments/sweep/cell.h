// One cell of a sweep: a point of its axes with one repetition, which is one run of real brokers
// and robots. A cell's number is its place in the sweep file's order, from 1.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "experiments/sweep/fault.h"

namespace romano::experiments {

/// The QoS levels that a robot's messages take in turn.
class QosMix {
public:
    explicit QosMix(std::vector<std::uint8_t> levels);
    [[nodiscard]] std::uint8_t level(std::uint32_t sequence) const {
        return levels_[sequence % levels_.size()];
    }
    [[nodiscard]] std::uint32_t size() const { return static_cast<std::uint32_t>(levels_.size()); }
    /// As in the sweep file: "1", "0+1+2".
    [[nodiscard]] std::string text() const;
    friend auto operator<=>(const QosMix&, const QosMix&) = default;

private:
    std::vector<std::uint8_t> levels_;  // never empty
};
/// "0+1+2", each level as often as it is named. Empty when the text is none.
[[nodiscard]] std::optional<QosMix> parse_qos_mix(std::string_view text);

struct Cell {
    std::uint32_t number = 0;
    std::uint32_t brokers = 1;
    std::uint32_t robots = 1;
    double rate_per_s = 1;  // of each publisher
    std::uint32_t payload_octets = 32;
    QosMix qos{{1}};
    std::string elector;            // empty with one broker: nobody to elect, detect, wait for
    std::string detector;           // empty with one broker
    std::string acks;               // a number or "all"; empty with one broker
    std::string clients = "plain";  // or "protected", or "dtls": with keys
    std::string backbone = "wire";  // or "wifi", or "radio"; empty with one broker
    std::string router_baud;        // of UARTs: a number or "none"; empty where there are none
    std::string robot_baud;         // as well
    Fault fault = Fault::none;
    std::uint64_t seed = 1;
    std::uint32_t repetition = 1;

    /// By number first: the order of a sweep.
    friend auto operator<=>(const Cell&, const Cell&) = default;
};

/// For people, and empty where the cell has none: "backbone wifi", "routers 115200 baud", "robots
/// without UART".
[[nodiscard]] std::string backbone_text(const Cell& cell);
[[nodiscard]] std::string router_baud_text(const Cell& cell);
[[nodiscard]] std::string robot_baud_text(const Cell& cell);

/// For people: "3 brokers, 20 robots, 5/s, QoS 0+1+2, kill-leader".
[[nodiscard]] std::string describe(const Cell& cell);

}  // namespace romano::experiments
