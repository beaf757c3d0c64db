#include "overlay/sim/world.h"

#include <algorithm>

#include "overlay/sim/seed.h"

namespace romano::sim {

namespace {
Endpoint endpoint(std::uint8_t subnet, std::size_t host, std::uint16_t port) {
    Endpoint endpoint{.port = port, .family = Endpoint::Family::ipv4};
    endpoint.address = {10, subnet, static_cast<std::uint8_t>(host / 250),
                        static_cast<std::uint8_t>(host % 250 + 1)};
    return endpoint;
}
}  // namespace

World::World(std::uint64_t seed)
    : seed_(seed), clients_(events_, trace_, seed_of(seed, "client network")) {}

Endpoint World::service_address(std::size_t broker) {
    return endpoint(1, broker, 1883);
}

Endpoint World::cell_group() {
    return {.address = {239, 18, 83, 1}, .port = 1884, .family = Endpoint::Family::ipv4};
}

Robot& World::add_robot(RobotOptions options) {
    const std::size_t index = robots_.size();
    if (options.address.family == Endpoint::Family::none) {
        options.address = endpoint(2, index, 5'000);
    }
    if (options.node == Node{}) {
        options.node = Node{first_robot_node + static_cast<std::uint32_t>(index)};
    }
    if (options.broker.family == Endpoint::Family::none) options.broker = service_address(0);
    if (options.name.empty()) options.name = "robot" + std::to_string(index);
    robots_.push_back(std::make_unique<Robot>(options, events_, clients_, trace_, ledger_,
                                              seed_of(seed_, "robot", index)));
    return *robots_.back();
}

bool World::run_until(const std::function<bool()>& condition, Duration limit, Duration step) {
    const Instant end = now() + limit;
    while (!condition()) {
        if (now() >= end) return false;
        run_for(step);
    }
    return true;
}

bool World::robots_are_idle() const {
    return std::ranges::all_of(
        robots_, [](const auto& robot) { return !robot->is_on() || robot->is_idle(); });
}

}  // namespace romano::sim
