// The plant: nothing comes of nothing, and near its set point it is the linear one of the theory.
#include "experiments/loops/cart_pole.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>

#include "experiments/loops/pendulum.h"

namespace romano::experiments::cart_pole_test {
namespace {

using namespace std::chrono_literals;

TEST(CartPole, KeepsItsEnergyWithoutFrictionAndForces) {
    CartPoleBody body;
    body.cart_friction = 0;
    const CartPoleState start{.position_m = 0, .speed_m_s = 0.3, .angle_rad = 0.2, .turn_rad_s = 0};
    const double energy = energy_of(body, start);
    CartPoleState state = start;
    for (int i = 0; i < 1'000; ++i) {
        state = after(body, state, {}, 10ms);
        ASSERT_NEAR(energy_of(body, state), energy, 1e-6) << i;
    }
    EXPECT_GT(std::abs(state.angle_rad - start.angle_rad), 0.1);  // it has moved, has it not
}

TEST(CartPole, GainsWhatItsForcesDoAndLosesWhatRubs) {
    const CartPoleBody body;
    CartPoleState state{.angle_rad = 0.1};
    const double energy = energy_of(body, state);
    const CartPoleForces forces{.on_cart_n = 2, .on_pole_nm = 0.05};
    double work = 0;
    for (int i = 0; i < 5'000; ++i) {
        const CartPoleState before = state;
        state = after(body, state, forces, 100us);
        const double speed = (before.speed_m_s + state.speed_m_s) / 2;
        const double turn = (before.turn_rad_s + state.turn_rad_s) / 2;
        work += 1e-4 * (forces.on_cart_n * speed + forces.on_pole_nm * turn -
                        body.cart_friction * speed * speed);
    }
    EXPECT_NEAR(energy_of(body, state) - energy, work, 1e-4);
}

TEST(CartPole, StepsThatDivideATimeDifferentlyEndAtOneState) {
    const CartPoleBody body;
    const CartPoleState start{.angle_rad = 0.1, .turn_rad_s = -0.5};
    const CartPoleState whole = after(body, start, {.on_cart_n = 1}, 20ms);
    const CartPoleState parts =
        after(body, after(body, start, {.on_cart_n = 1}, 12'300us), {.on_cart_n = 1}, 7'700us);
    EXPECT_NEAR(whole.angle_rad, parts.angle_rad, 1e-9);
    EXPECT_NEAR(whole.speed_m_s, parts.speed_m_s, 1e-9);
}

TEST(CartPole, IsNearItsSetPointTheLinearPlant) {
    const CartPoleBody body;
    const LinearPlant plant = linearised(body);
    constexpr double step = 1e-6;
    const auto difference = [&](const CartPoleState& state,
                                const CartPoleForces& forces) -> Eigen::Vector4d {
        CartPoleState back = state;
        back.position_m = -back.position_m;
        back.speed_m_s = -back.speed_m_s;
        back.angle_rad = -back.angle_rad;
        back.turn_rad_s = -back.turn_rad_s;
        const CartPoleState high = rate_of(body, state, forces);
        const CartPoleState low = rate_of(body, back, {.on_cart_n = -forces.on_cart_n});
        return Eigen::Vector4d{high.position_m - low.position_m, high.speed_m_s - low.speed_m_s,
                               high.angle_rad - low.angle_rad, high.turn_rad_s - low.turn_rad_s} /
               (2 * step);
    };
    EXPECT_LT((difference({.position_m = step}, {}) - plant.a.col(0)).norm(), 1e-8);
    EXPECT_LT((difference({.speed_m_s = step}, {}) - plant.a.col(1)).norm(), 1e-8);
    EXPECT_LT((difference({.angle_rad = step}, {}) - plant.a.col(2)).norm(), 1e-8);
    EXPECT_LT((difference({.turn_rad_s = step}, {}) - plant.a.col(3)).norm(), 1e-8);
    EXPECT_LT((difference({}, {.on_cart_n = step}) - plant.b).norm(), 1e-8);
}

}  // namespace
}  // namespace romano::experiments::cart_pole_test
