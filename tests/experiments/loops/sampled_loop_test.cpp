// The theory, where the answer is known on paper.
#include "experiments/loops/sampled_loop.h"

#include <gtest/gtest.h>

#include <cmath>

#include "experiments/loops/pendulum.h"

namespace romano::experiments::sampled_loop_test {
namespace {

/// dx/dt = pole x + u.
LinearPlant scalar(double pole) {
    return {Eigen::MatrixXd::Constant(1, 1, pole), Eigen::VectorXd::Constant(1, 1)};
}
Eigen::RowVectorXd gain(double k) {
    return Eigen::RowVectorXd::Constant(1, k);
}

TEST(SampledLoop, WithoutDelayMultipliesAScalarByItsSampledPole) {
    // An integrator: x + h u, with u = -k x.
    EXPECT_NEAR(SampledLoop(scalar(0), gain(3), 0.1, 0).spectral_radius(), 1 - 0.3, 1e-12);
    // exp(a h) - k (exp(a h) - 1) / a.
    const double grown = std::exp(2 * 0.1);
    EXPECT_NEAR(SampledLoop(scalar(2), gain(5), 0.1, 0).spectral_radius(),
                grown - 5 * (grown - 1) / 2, 1e-12);
}

TEST(SampledLoop, OfAnIntegratorBearsADelayOfOneOverItsGain) {
    // z^2 - (1 - k (h - d)) z + k d = 0 leaves the unit circle at k d = 1, for d up to h: Jury.
    EXPECT_NEAR(delay_margin_s(scalar(0), gain(12), 0.1, 0, Stability::mean_square, 1), 1 / 12.0,
                2e-5);
    // A whole period of delay: z^2 - z + k h = 0.
    EXPECT_NEAR(delay_margin_s(scalar(0), gain(10), 0.1, 0, Stability::mean_square, 1), 0.1, 2e-5);
}

TEST(SampledLoop, BearsOfFineSamplesTheDelayOfAContinuousOne) {
    // dx/dt = -k x(t - delay): pi / (2 k). A held sample adds half a period of delay.
    const double k = 4;
    const double period_s = 0.02;  // of which twenty are on their way
    EXPECT_NEAR(delay_margin_s(scalar(0), gain(k), period_s, 0, Stability::mean_square, 1),
                3.14159265 / (2 * k) - period_s / 2, 1e-4);
}

TEST(SampledLoop, OfADeadBeatIntegratorBearsTheLossOfEachThirdRound) {
    // u h = -x: a round that arrives makes x zero, a lost one goes on with the u before. With a, c,
    // b the means of x^2, x u h, (u h)^2 and losses p: a' = p (a + 2 c + b), c' = p (c + b),
    // b' = (1 - p) a + p b, which has the eigenvalue 1 where 1 - p = 2 p.
    const double period_s = 0.1;
    const SampledLoop loop(scalar(0), gain(1 / period_s), period_s, 0);
    EXPECT_NEAR(loop.spectral_radius(), 0, 1e-6);
    EXPECT_LT(loop.mean_square_radius(0.33), 1);
    EXPECT_NEAR(loop.mean_square_radius(1 / 3.0), 1, 1e-9);
    EXPECT_GT(loop.mean_square_radius(0.34), 1);
}

TEST(SampledLoop, UsuallyGrowsNoFasterThanItsMeanSquare) {
    const SampledLoop loop(scalar(1), gain(3), 0.2, 0.07);
    const double radius = loop.mean_square_radius(0.3);
    EXPECT_GT(radius, std::pow(loop.usual_growth(0.3, 1, 100'000), 2));  // Jensen
    EXPECT_LT(loop.usual_growth(0, 1, 100'000), 1);
    EXPECT_NEAR(loop.usual_growth(0, 1, 100'000), loop.spectral_radius(), 1e-3);
}

TEST(SampledLoop, BearsLessDelayTheMoreIsLostAndUsuallyMoreThanInMeanSquare) {
    const CartPoleBody body;
    const LinearPlant plant = linearised(body);
    const Eigen::RowVectorXd k = balancing_gain(body);
    const auto margin = [&](double loss, Stability stability) {
        return delay_margin_s(plant, k, 0.04, loss, stability, 0.2);
    };
    const double without = margin(0, Stability::mean_square);
    EXPECT_GT(without, 0.05);
    EXPECT_LT(margin(0.1, Stability::mean_square), without);
    EXPECT_LT(margin(0.3, Stability::mean_square), margin(0.1, Stability::mean_square));
    EXPECT_GE(margin(0.3, Stability::usual), margin(0.3, Stability::mean_square));
    EXPECT_LT(margin(0.3, Stability::usual), without);
}

TEST(BestGain, IsOnPaperTheSameForAScalar) {
    // p = q + a^2 p r / (r + b^2 p) of the sampled integrator: a = 1, b = h.
    const double h = 0.1;
    const double q = 2;
    const double r = 0.5;
    const double p = (q + std::sqrt(q * q + 4 * q * r / (h * h))) / 2;
    EXPECT_NEAR(best_gain(scalar(0), h, Eigen::MatrixXd::Constant(1, 1, q), r)[0],
                h * p / (r + h * h * p), 1e-9);
}

}  // namespace
}  // namespace romano::experiments::sampled_loop_test
