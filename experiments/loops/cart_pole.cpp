#include "experiments/loops/cart_pole.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace romano::experiments {
namespace {

constexpr Duration step{std::chrono::milliseconds{1}};

double inertia_at_hinge(const CartPoleBody& body) {
    return body.pole_kg * body.half_pole_m * body.half_pole_m * 4 / 3;
}

CartPoleState moved(const CartPoleState& state, const CartPoleState& rate, double seconds) {
    return {.position_m = state.position_m + rate.position_m * seconds,
            .speed_m_s = state.speed_m_s + rate.speed_m_s * seconds,
            .angle_rad = state.angle_rad + rate.angle_rad * seconds,
            .turn_rad_s = state.turn_rad_s + rate.turn_rad_s * seconds};
}

CartPoleState stepped(const CartPoleBody& body, const CartPoleState& state,
                      const CartPoleForces& forces, double seconds) {
    const CartPoleState k1 = rate_of(body, state, forces);
    const CartPoleState k2 = rate_of(body, moved(state, k1, seconds / 2), forces);
    const CartPoleState k3 = rate_of(body, moved(state, k2, seconds / 2), forces);
    const CartPoleState k4 = rate_of(body, moved(state, k3, seconds), forces);
    CartPoleState next = moved(state, k1, seconds / 6);
    next = moved(next, k2, seconds / 3);
    next = moved(next, k3, seconds / 3);
    return moved(next, k4, seconds / 6);
}

}  // namespace

CartPoleState rate_of(const CartPoleBody& body, const CartPoleState& state,
                      const CartPoleForces& forces) {
    // Two equations of motion, of all together along the rail and of the pole around its hinge:
    //   mass * acceleration + coupling * turning = along
    //   coupling * acceleration + inertia * turning = around
    const double moment = body.pole_kg * body.half_pole_m;
    const double mass = body.cart_kg + body.pole_kg;
    const double inertia = inertia_at_hinge(body);
    const double coupling = moment * std::cos(state.angle_rad);
    const double along = forces.on_cart_n - body.cart_friction * state.speed_m_s +
                         moment * state.turn_rad_s * state.turn_rad_s * std::sin(state.angle_rad);
    const double around =
        forces.on_pole_nm + moment * body.gravity_m_s2 * std::sin(state.angle_rad);
    const double determinant = mass * inertia - coupling * coupling;
    return {.position_m = state.speed_m_s,
            .speed_m_s = (inertia * along - coupling * around) / determinant,
            .angle_rad = state.turn_rad_s,
            .turn_rad_s = (mass * around - coupling * along) / determinant};
}

double energy_of(const CartPoleBody& body, const CartPoleState& state) {
    const double moment = body.pole_kg * body.half_pole_m;
    const double v = state.speed_m_s;
    const double w = state.turn_rad_s;
    return (body.cart_kg + body.pole_kg) * v * v / 2 + inertia_at_hinge(body) * w * w / 2 +
           moment * v * w * std::cos(state.angle_rad) +
           moment * body.gravity_m_s2 * std::cos(state.angle_rad);
}

CartPoleState after(const CartPoleBody& body, CartPoleState state, const CartPoleForces& forces,
                    Duration time) {
    for (Duration left = time; left > Duration{0}; left -= step) {
        const std::chrono::duration<double> now = std::min(left, step);
        state = stepped(body, state, forces, now.count());
    }
    return state;
}

}  // namespace romano::experiments
