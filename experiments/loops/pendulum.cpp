#include "experiments/loops/pendulum.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

#include "firmware/posix/octets.h"
#include "overlay/sim/seed.h"
#include "romano/base/random.h"

namespace romano::experiments {
namespace {

using firmware::be32;
using firmware::put_be32;

constexpr double per_unit = 1e6;
constexpr Duration looks_each{std::chrono::milliseconds{1}};
constexpr Duration gust_lasts{std::chrono::milliseconds{100}};

Eigen::Vector4d vector_of(const CartPoleState& state) {
    return {state.position_m, state.speed_m_s, state.angle_rad, state.turn_rad_s};
}

void put(std::uint8_t* out, double value) {
    constexpr double most = 2'147'483'647;
    put_be32(out, std::clamp(value * per_unit, -most, most));
}

}  // namespace

LinearPlant linearised(const CartPoleBody& body) {
    // The equations of rate_of() with cos(angle) = 1, sin(angle) = angle and turn^2 = 0.
    const double mass = body.cart_kg + body.pole_kg;
    const double moment = body.pole_kg * body.half_pole_m;
    const double inertia = moment * body.half_pole_m * 4 / 3;
    const double weight = moment * body.gravity_m_s2;
    const double determinant = mass * inertia - moment * moment;
    LinearPlant plant{Eigen::MatrixXd::Zero(4, 4), Eigen::VectorXd::Zero(4)};
    plant.a(0, 1) = 1;
    plant.a(1, 1) = -inertia * body.cart_friction / determinant;
    plant.a(1, 2) = -moment * weight / determinant;
    plant.a(2, 3) = 1;
    plant.a(3, 1) = moment * body.cart_friction / determinant;
    plant.a(3, 2) = mass * weight / determinant;
    plant.b(1) = inertia / determinant;
    plant.b(3) = -moment / determinant;
    return plant;
}

Eigen::RowVectorXd balancing_gain(const CartPoleBody& body) {
    constexpr double period_s = 0.02;
    const Eigen::MatrixXd weights = Eigen::Vector4d{1, 0.1, 10, 0.1}.asDiagonal();
    return best_gain(linearised(body), period_s, weights, 0.1);
}

double Gusts::at(Duration since_release) const {
    const auto number = static_cast<std::uint64_t>(since_release / gust_lasts);
    Random random(sim::seed_of(seed, "gust", number));
    constexpr double half = 2'147'483'648.0;
    return strength_nm * (static_cast<double>(random.next()) / half - 1);
}

Duration Gusts::end_of(Duration since_release) {
    return (since_release / gust_lasts + 1) * gust_lasts;
}

void Pendulum::release(Instant now) {
    released_at_ = moved_at_ = now;
    is_free_ = true;
}

void Pendulum::move_on(Instant now) {
    if (!is_free_) return;
    while (moved_at_ < now) {
        const Duration blown = moved_at_ - released_at_;
        const Instant next =
            std::min({now, moved_at_ + looks_each, released_at_ + Gusts::end_of(blown)});
        const CartPoleForces forces{.on_cart_n = force_n_, .on_pole_nm = gusts_.at(blown)};
        state_ = after(body_, state_, forces, next - moved_at_);
        moved_at_ = next;
        const double angle = std::abs(state_.angle_rad);
        greatest_angle_rad_ = std::max(greatest_angle_rad_, angle);
        if (!has_fallen_ && angle < fallen_rad) continue;
        has_fallen_ = true;
        is_free_ = false;  // it lies there
        return;
    }
}

void Pendulum::shove(Instant now, double turn_rad_s) {
    move_on(now);
    state_.turn_rad_s += turn_rad_s;
}

std::size_t Pendulum::sense(Instant now, MutableBytes room) {
    move_on(now);
    const Eigen::Vector4d numbers = vector_of(state_);
    for (Eigen::Index i = 0; i < numbers.size(); ++i) put(room.data() + 4 * i, numbers[i]);
    return 16;
}

void Pendulum::carry_out(Instant now, Bytes value) {
    move_on(now);
    const double force = value.size() == 4 ? be32(value, 0) / per_unit : 0;
    force_n_ = std::clamp(force, -most_force_n, most_force_n);
}

void Pendulum::fall_back(Instant now, control::Fallback fallback) {
    move_on(now);
    ++falls_back_;
    if (fallback != control::Fallback::hold) force_n_ = 0;
}

std::optional<std::size_t> Balancer::control(Instant, const RomanoId&,
                                             const control::Sample& sample, MutableBytes room) {
    if (sample.value.size() != 16) return std::nullopt;
    Eigen::Vector4d state;
    for (Eigen::Index i = 0; i < state.size(); ++i) {
        state[i] = be32(sample.value, static_cast<std::size_t>(4 * i)) / per_unit;
    }
    put(room.data(), -gain_.dot(state));
    return 4;
}

}  // namespace romano::experiments
