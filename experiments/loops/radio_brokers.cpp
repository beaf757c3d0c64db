#include "experiments/loops/radio_brokers.h"

#include <algorithm>

#include "experiments/loops/simulated_brokers.h"
#include "overlay/radio/radio_network.h"

namespace romano::experiments {
namespace {

constexpr std::uint32_t most_robots = 5;  // of a formation
constexpr std::uint32_t router_baud = 230'400;
constexpr double metres_between_routers = 4;

radio::RadioOptions radio_options(std::size_t cells) {
    radio::RadioOptions options;
    options.router_baud = router_baud;
    options.robot_baud.reset();  // controller and radio are one chip
    for (std::size_t cell = 0; cell < cells; ++cell) {
        radio::RadioCell& one = options.cells.emplace_back();
        one.channel = lowpan::first_channel + 5 * static_cast<unsigned>(cell);
        one.router = {metres_between_routers * static_cast<double>(cell), 0};
        for (std::uint32_t robot = 0; robot < most_robots; ++robot) {
            one.robots.push_back({SimulatedSurroundings::address_of_port(robot),
                                  {metres_between_routers / 2, 1 + static_cast<double>(robot)}});
        }
    }
    return options;
}

class RadioBrokers final : public SimulatedBrokers {
public:
    RadioBrokers(std::uint64_t seed, std::size_t brokers)
        : SimulatedBrokers(seed, brokers),
          network_(world(), radio_options(std::min<std::size_t>(brokers, 2))) {}

private:
    void drive_on() override {
        for (std::uint32_t robot = 0; robot < most_robots; ++robot) {
            network_.join(SimulatedSurroundings::address_of_port(robot), 1);
        }
    }

    radio::RadioNetwork network_;
};

}  // namespace

const bool has_radio = true;

std::unique_ptr<FaultyBrokers> make_radio_brokers(std::uint64_t seed, std::size_t brokers) {
    return std::make_unique<RadioBrokers>(seed, brokers);
}

}  // namespace romano::experiments
