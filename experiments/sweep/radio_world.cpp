#include "experiments/sweep/radio_world.h"

#include <string>

#include "experiments/sweep/baud.h"
#include "experiments/sweep/simulated_world.h"
#include "overlay/radio/layout.h"
#include "overlay/radio/radio_network.h"

namespace romano::experiments {
namespace {

constexpr std::uint8_t robots_network = 100;

/// Robots are dealt to the brokers in turn, as the swarm does.
radio::RadioOptions radio_of(const SweepSettings& settings, const Cell& cell) {
    radio::RadioOptions options;
    options.router_baud = baud_of(cell.router_baud);
    options.robot_baud = baud_of(cell.robot_baud);
    options.cells.resize(cell.brokers);
    for (std::size_t i = 0; i < options.cells.size(); ++i) {
        radio::RadioCell& one = options.cells[i];
        one.channel = lowpan::first_channel + static_cast<unsigned>(i % settings.radio.channels);
        one.router = radio::place_on_grid(i, cell.brokers, settings.radio.router_distance_m);
        const std::size_t robots = (cell.robots + cell.brokers - 1 - i) / cell.brokers;
        for (std::size_t j = 0; j < robots; ++j) {
            one.robots.push_back(
                {SimulatedSurroundings::address_of_port(
                     static_cast<std::uint32_t>(i + j * cell.brokers), robots_network),
                 radio::place_around(one.router, j, robots)});
        }
    }
    if (cell.backbone == "radio") {
        options.backbone = radio::BackboneOnAir{.channel = lowpan::first_channel, .radios = {}};
        for (std::size_t i = 0; i < options.cells.size(); ++i) {
            options.backbone->radios.push_back(
                {sim::World::broker_node(i), options.cells[i].router});
        }
    }
    return options;
}

class RadioWorld final : public SimulatedWorld {
public:
    RadioWorld(const SweepSettings& settings, const Cell& cell)
        : SimulatedWorld(settings, cell),
          robots_(world(), clients_node, robots_network),
          network_(world(), radio_of(settings, cell)) {
        peers().set_backbone(network_.backbone());
    }

    [[nodiscard]] Surroundings& robots() override { return robots_; }

private:
    SimulatedSurroundings robots_;
    radio::RadioNetwork network_;
};

}  // namespace

void check_radio(const SweepSettings& settings, const std::vector<Cell>& cells) {
    for (const Cell& cell : cells) {
        const auto problem = radio::problem_with(radio_of(settings, cell));
        if (problem) throw SweepError("`world = \"radio\"`: " + *problem);
    }
}

std::unique_ptr<CellWorld> make_radio_world(const SweepSettings& settings, const Cell& cell) {
    return std::make_unique<RadioWorld>(settings, cell);
}

}  // namespace romano::experiments
