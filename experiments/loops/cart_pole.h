// A cart on a rail with a pole that stands on it, the plant that falls without control. Nonlinear;
// the pole is a uniform rod without friction at its hinge.
#pragma once

#include "romano/base/time.h"

namespace romano::experiments {

struct CartPoleBody {
    double cart_kg = 1;
    double pole_kg = 0.2;
    double half_pole_m = 0.5;    // from the hinge to the middle
    double cart_friction = 0.5;  // N for each m/s
    double gravity_m_s2 = 9.81;
};

struct CartPoleState {
    double position_m = 0;
    double speed_m_s = 0;
    double angle_rad = 0;  // 0: upright; the top moves to where positions grow
    double turn_rad_s = 0;
};

/// What acts on it from outside.
struct CartPoleForces {
    double on_cart_n = 0;
    double on_pole_nm = 0;  // around the hinge
};

/// The change of each number of the state, a second.
[[nodiscard]] CartPoleState rate_of(const CartPoleBody& body, const CartPoleState& state,
                                    const CartPoleForces& forces);

/// Kinetic and potential, in J; 0 J where the pole lies level.
[[nodiscard]] double energy_of(const CartPoleBody& body, const CartPoleState& state);

/// The state after `time` of constant forces: Runge and Kutta's method of fourth order in steps of
/// a millisecond, the last one shorter.
[[nodiscard]] CartPoleState after(const CartPoleBody& body, CartPoleState state,
                                  const CartPoleForces& forces, Duration time);

}  // namespace romano::experiments
