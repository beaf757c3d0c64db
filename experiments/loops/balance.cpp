#include "experiments/loops/balance.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>

#include "experiments/loops/loop_robot.h"
#include "experiments/loops/pendulum.h"
#include "experiments/robots/simulated_surroundings.h"
#include "overlay/sim/lone_world.h"
#include "overlay/sim/seed.h"

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;

constexpr sim::Node robots_node{5'000};
constexpr int ways = 4;  // to the broker and on, there and back
constexpr double least_start_rad = 0.005;
constexpr double most_start_rad = 0.015;

/// Of each of the four ways, so that so much of the rounds is lost.
std::uint32_t way_loss_ppm(double loss) {
    return static_cast<std::uint32_t>(std::lround(1e6 * (1 - std::pow(1 - loss, 1.0 / ways))));
}

CartPoleState start_of(std::uint64_t seed) {
    Random random(sim::seed_of(seed, "start"));
    const double share = random.next() / 4'294'967'296.0;
    const double angle = least_start_rad + share * (most_start_rad - least_start_rad);
    CartPoleState start;
    start.angle_rad = random.below(2) == 0 ? angle : -angle;
    return start;
}

}  // namespace

BalanceRun balance(const CartPoleBody& body, const BalanceCase& setting) {
    sim::LoneWorld world(setting.seed);
    const CartPoleState start = start_of(setting.seed);
    Pendulum pendulum(body, start, {});
    Balancer balancer(balancing_gain(body));
    SimulatedSurroundings around(world, robots_node);
    LoopRobot cart(around, setting.seed, 1, simulated_broker_address(0), pendulum);
    LoopRobot law(around, setting.seed, 2, simulated_broker_address(0), balancer);
    cart.start();
    law.start();
    const LoopSettings settings{
        .period_ms = setting.period_ms,
        .deadline_ms = static_cast<std::uint16_t>(control::PlantLoop::window * setting.period_ms),
        .fallback = control::Fallback::hold};
    law.open(cart.id(), law.id(), settings);
    if (!world.run_until([&] { return cart.is_controlled(); }, 20s)) {
        throw std::runtime_error("the pendulum's loop did not begin within 20 s");
    }
    const Duration way = setting.delay / ways;
    world.clients().set_quality(
        {.delay_min = way, .delay_max = way, .loss_ppm = way_loss_ppm(setting.loss)});
    const std::uint32_t samples = cart.loop().counters().samples;
    const std::uint32_t commands = cart.loop().counters().accepted;
    pendulum.release(world.now());
    const Instant begun = world.now();
    const Instant end = begun + setting.lasts;
    while (world.now() < end && !pendulum.has_fallen()) {
        if (end - world.now() == setting.lasts / 5) pendulum.forget_angle();
        world.run_for(std::min<Duration>(setting.lasts / 100, end - world.now()));
        pendulum.move_on(world.now());
    }
    const control::LoopCounters& counters = cart.loop().counters();
    const auto on_their_way =
        static_cast<std::uint32_t>(setting.delay / std::chrono::milliseconds{setting.period_ms});
    return {.stays_up =
                !pendulum.has_fallen() && pendulum.greatest_angle_rad() < std::abs(start.angle_rad),
            .stood_s = std::chrono::duration<double>(world.now() - begun).count(),
            .samples = counters.samples - samples - on_their_way,
            .commands = counters.accepted - commands,
            .greatest_delay_s = cart.loop().ages().greatest / 1e6};
}

}  // namespace romano::experiments
