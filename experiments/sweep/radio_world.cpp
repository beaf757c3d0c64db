#include "experiments/sweep/radio_world.h"

#include <cmath>
#include <numbers>
#include <string>

#include "experiments/sweep/simulated_world.h"
#include "overlay/radio/radio_network.h"

namespace romano::experiments {
namespace {

constexpr double metres_to_robot = 2;  // from its router
constexpr std::uint8_t robots_network = 100;

/// Robots are dealt to the brokers in turn, as the swarm does.
template <typename AddressOf>
radio::RadioOptions options_of(const SweepSettings& settings, const Cell& cell,
                               const AddressOf& address_of) {
    radio::RadioOptions options;
    options.router_baud = settings.radio.router_baud;
    options.robot_baud = settings.radio.robot_baud;
    options.cells.resize(cell.brokers);
    const auto side = static_cast<std::size_t>(std::ceil(std::sqrt(cell.brokers)));
    for (std::size_t i = 0; i < options.cells.size(); ++i) {
        radio::RadioCell& one = options.cells[i];
        one.channel = lowpan::first_channel + static_cast<unsigned>(i % settings.radio.channels);
        one.router = {settings.radio.router_distance_m * static_cast<double>(i % side),
                      settings.radio.router_distance_m * static_cast<double>(i / side)};
        const std::size_t robots = (cell.robots + cell.brokers - 1 - i) / cell.brokers;
        for (std::size_t j = 0; j < robots; ++j) {
            const double angle =
                2 * std::numbers::pi * static_cast<double>(j) / static_cast<double>(robots);
            one.robots.push_back({address_of(i + j * cell.brokers),
                                  {one.router.x_m + metres_to_robot * std::cos(angle),
                                   one.router.y_m + metres_to_robot * std::sin(angle)}});
        }
    }
    return options;
}

class RadioWorld final : public SimulatedWorld {
public:
    RadioWorld(const SweepSettings& settings, const Cell& cell)
        : SimulatedWorld(settings, cell),
          robots_(world(), clients_node, robots_network),
          network_(world(), options_of(settings, cell, [](std::size_t robot) {
                       return SimulatedSurroundings::address_of_port(
                           static_cast<std::uint32_t>(robot), robots_network);
                   })) {}

    [[nodiscard]] Surroundings& robots() override { return robots_; }

private:
    SimulatedSurroundings robots_;
    radio::RadioNetwork network_;
};

}  // namespace

void check_radio(const SweepSettings& settings, const std::vector<Cell>& cells) {
    for (const Cell& cell : cells) {
        const auto problem =
            radio::problem_with(options_of(settings, cell, [](std::size_t) { return Endpoint{}; }));
        if (problem) throw SweepError("`world = \"radio\"`: " + *problem);
    }
}

std::unique_ptr<CellWorld> make_radio_world(const SweepSettings& settings, const Cell& cell) {
    return std::make_unique<RadioWorld>(settings, cell);
}

}  // namespace romano::experiments
