// Theory: a linear plant under state feedback over a network. Each period a sample is taken; the
// command that is made of it is in force one delay later, and until the next one; some rounds are
// lost, each by itself, and then the command before goes on.
//
// Astrom and Wittenmark, "Computer-Controlled Systems", section 3.2, for the delay. A loop that
// loses rounds by chance is a linear system that jumps: its state and the inputs on their way are
// one vector z, and each period multiplies it by one of two matrices.
#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace romano::experiments {

/// dx/dt = a x + b u, with one input.
struct LinearPlant {
    Eigen::MatrixXd a;
    Eigen::VectorXd b;
};

/// The row k of u = -k x that is best for sum(x' states x + input u^2) with a sample each
/// `period_s` and no delay: the Riccati equation's limit, by repetition.
[[nodiscard]] Eigen::RowVectorXd best_gain(const LinearPlant& plant, double period_s,
                                           const Eigen::MatrixXd& states, double input);

class SampledLoop {
public:
    SampledLoop(const LinearPlant& plant, const Eigen::RowVectorXd& gain, double period_s,
                double delay_s);

    /// Below 1: without losses everything dies away.
    [[nodiscard]] double spectral_radius() const;
    /// Below 1: the mean of the squares dies away when `loss` of the rounds are lost. The spectral
    /// radius of the map of second moments, E[z z'] to that a period later.
    [[nodiscard]] double mean_square_radius(double loss) const;
    /// Below 1: nearly every course of losses lets everything die away, though the mean of the
    /// squares may grow. The factor of growth a period, over a course of `periods` by `seed`.
    [[nodiscard]] double usual_growth(double loss, std::uint64_t seed, int periods) const;

private:
    Eigen::MatrixXd arrived_;  // what a period makes of z
    Eigen::MatrixXd lost_;     // the same when its round is lost
};

/// In which sense a loop is stable.
enum class Stability : std::uint8_t { mean_square, usual };

/// The least delay, to 10 us, with which the loop is not stable; 0 when it is not even without one,
/// `most_s` when it is with all up to that.
[[nodiscard]] double delay_margin_s(const LinearPlant& plant, const Eigen::RowVectorXd& gain,
                                    double period_s, double loss, Stability stability,
                                    double most_s);

}  // namespace romano::experiments
