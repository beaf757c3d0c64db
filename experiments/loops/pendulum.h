// The cart with the pole as a robot's body, and the law that keeps the pole upright.
//
// On the wire, big-endian i32: a sample has position, speed, angle and turn in millionths of m,
// m/s, rad and rad/s; a command has the force on the cart in millionths of N.
#pragma once

#include <cstdint>

#include "experiments/loops/cart_pole.h"
#include "experiments/loops/loop_robot.h"
#include "experiments/loops/sampled_loop.h"

namespace romano::experiments {

/// The plant near its set point: x is position, speed, angle, turn; u the force on the cart.
[[nodiscard]] LinearPlant linearised(const CartPoleBody& body);

/// What the shipped law of this experiment is: best for 50 samples a second without delay, with the
/// weights 1, 0.1, 10, 0.1 for the squares of the state's numbers and 0.1 for that of the force.
[[nodiscard]] Eigen::RowVectorXd balancing_gain(const CartPoleBody& body);

/// Wind on the pole: another torque around the hinge each 100 ms from the pole's release on, from
/// -strength to strength, uniformly, each by the seed and its number alone: whatever else happens,
/// it blows the same.
struct Gusts {
    double strength_nm = 0;
    std::uint64_t seed = 0;

    [[nodiscard]] double at(Duration since_release) const;
    [[nodiscard]] static Duration end_of(Duration since_release);
};

class Pendulum final : public Device {
public:
    static constexpr double fallen_rad = 0.5;
    static constexpr double most_force_n = 50;  // of the cart's motor

    Pendulum(const CartPoleBody& body, const CartPoleState& start, const Gusts& gusts)
        : body_(body), state_(start), gusts_(gusts) {}

    /// Somebody holds it until then. From then on it is left to itself and its commands.
    void release(Instant now);
    /// It is where it is at that time.
    void move_on(Instant now);
    /// Somebody hits the pole, which turns that much faster at once.
    void shove(Instant now, double turn_rad_s);

    [[nodiscard]] const CartPoleState& state() const { return state_; }
    [[nodiscard]] bool has_fallen() const { return has_fallen_; }
    /// The greatest angle, either way, since forget_angle().
    [[nodiscard]] double greatest_angle_rad() const { return greatest_angle_rad_; }
    void forget_angle() { greatest_angle_rad_ = 0; }
    [[nodiscard]] std::uint32_t falls_back() const { return falls_back_; }

    std::size_t sense(Instant now, MutableBytes room) override;
    void carry_out(Instant now, Bytes value) override;
    /// Without a command the motor is off, unless it is told to go on.
    void fall_back(Instant now, control::Fallback fallback) override;

private:
    CartPoleBody body_;
    CartPoleState state_;
    Gusts gusts_;
    bool is_free_ = false;
    bool has_fallen_ = false;
    double force_n_ = 0;
    double greatest_angle_rad_ = 0;
    std::uint32_t falls_back_ = 0;
    Instant released_at_{};
    Instant moved_at_{};
};

class Balancer final : public Device {
public:
    explicit Balancer(const Eigen::RowVectorXd& gain) : gain_(gain) {}

    std::optional<std::size_t> control(Instant now, const RomanoId& plant,
                                       const control::Sample& sample, MutableBytes room) override;

private:
    Eigen::RowVectorXd gain_;
};

}  // namespace romano::experiments
