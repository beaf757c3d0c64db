#include "experiments/loops/sampled_loop.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <functional>

#include "romano/base/random.h"

namespace romano::experiments {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

/// By its series, of a part of the matrix so small that it ends soon, and by squaring. (Eigen's own
/// is one of its unsupported modules, and the compiler needs minutes for it with sanitizers.)
MatrixXd exponential_of(const MatrixXd& matrix) {
    constexpr int terms = 18;  // 0.5^18 / 18! is far below what a double holds
    const int squarings = std::max(0, std::ilogb(matrix.norm() + 1e-300) + 2);
    const MatrixXd small = matrix * std::ldexp(1.0, -squarings);
    MatrixXd term = MatrixXd::Identity(matrix.rows(), matrix.cols());
    MatrixXd sum = term;
    for (int i = 1; i <= terms; ++i) {
        term = term * small / i;
        sum += term;
    }
    for (int i = 0; i < squarings; ++i) sum = sum * sum;
    return sum;
}

/// What a constant input makes of the state in some time: x becomes state x + input u.
struct Held {
    MatrixXd state;
    VectorXd input;
};

Held held_for(const LinearPlant& plant, double seconds) {
    const Index n = plant.a.rows();
    MatrixXd both = MatrixXd::Zero(n + 1, n + 1);
    both.topLeftCorner(n, n) = plant.a * seconds;
    both.topRightCorner(n, 1) = plant.b * seconds;
    const MatrixXd grown = exponential_of(both);
    return {grown.topLeftCorner(n, n), grown.topRightCorner(n, 1)};
}

double spectral_radius_of(const MatrixXd& matrix) {
    return Eigen::EigenSolver<MatrixXd>(matrix, false).eigenvalues().cwiseAbs().maxCoeff();
}

/// The upper half of a symmetric matrix, as a column.
VectorXd half_of(const MatrixXd& symmetric) {
    const Index n = symmetric.rows();
    VectorXd half(n * (n + 1) / 2);
    Index at = 0;
    for (Index row = 0; row < n; ++row) {
        for (Index column = row; column < n; ++column) half[at++] = symmetric(row, column);
    }
    return half;
}

/// Where `is_stable` ends between `from`, where it holds, and `to`.
double end_of(const std::function<bool(double)>& is_stable, double from, double to, double within) {
    while (to - from > within) {
        const double middle = (from + to) / 2;
        (is_stable(middle) ? from : to) = middle;
    }
    return to;
}

}  // namespace

RowVectorXd best_gain(const LinearPlant& plant, double period_s, const MatrixXd& states,
                      double input) {
    const auto [a, b] = held_for(plant, period_s);
    MatrixXd cost = states;
    for (int i = 0; i < 100'000; ++i) {
        const RowVectorXd gain = (b.transpose() * cost * a) / (input + b.dot(cost * b));
        const MatrixXd next = states + a.transpose() * cost * (a - b * gain);
        const bool is_done = (next - cost).norm() <= 1e-12 * next.norm();
        cost = next;
        if (is_done) break;
    }
    return (b.transpose() * cost * a) / (input + b.dot(cost * b));
}

SampledLoop::SampledLoop(const LinearPlant& plant, const RowVectorXd& gain, double period_s,
                         double delay_s) {
    const auto whole = static_cast<Index>(std::floor(delay_s / period_s));
    const double late_s = delay_s - static_cast<double>(whole) * period_s;
    const Held first = held_for(plant, late_s);            // the input that was in force
    const Held then = held_for(plant, period_s - late_s);  // the one that has come
    const Index n = plant.a.rows();
    const Index in_force = n + whole;
    // z: the state, the commands of the last `whole` samples, newest first, and the input in force.
    const auto make = [&](bool arrives) {
        MatrixXd z = MatrixXd::Zero(n + whole + 1, n + whole + 1);
        RowVectorXd command = RowVectorXd::Zero(z.cols());  // of the sample that is taken now
        command.head(n) = -gain;
        RowVectorXd coming = RowVectorXd::Zero(z.cols());  // what is in force from now on
        if (!arrives) {
            coming[in_force] = 1;
        } else if (whole == 0) {
            coming = command;
        } else {
            coming[in_force - 1] = 1;
        }
        z.topLeftCorner(n, n) = then.state * first.state;
        z.block(0, in_force, n, 1) = then.state * first.input;
        z.topRows(n) += then.input * coming;
        if (whole > 0) z.row(n) = command;
        for (Index i = 1; i < whole; ++i) z(n + i, n + i - 1) = 1;
        z.row(in_force) = coming;
        return z;
    };
    arrived_ = make(true);
    lost_ = make(false);
}

double SampledLoop::spectral_radius() const {
    return spectral_radius_of(arrived_);
}

double SampledLoop::mean_square_radius(double loss) const {
    const Index n = arrived_.rows();
    MatrixXd map(n * (n + 1) / 2, n * (n + 1) / 2);
    Index column = 0;
    for (Index i = 0; i < n; ++i) {
        for (Index j = i; j < n; ++j) {
            MatrixXd moment = MatrixXd::Zero(n, n);
            moment(i, j) = moment(j, i) = 1;
            map.col(column++) = half_of((1 - loss) * arrived_ * moment * arrived_.transpose() +
                                        loss * lost_ * moment * lost_.transpose());
        }
    }
    return spectral_radius_of(map);
}

double SampledLoop::usual_growth(double loss, std::uint64_t seed, int periods) const {
    Random random(seed);
    const auto loss_ppm = static_cast<std::uint32_t>(std::lround(loss * 1e6));
    VectorXd z = VectorXd::Ones(arrived_.rows());
    double logarithm = 0;
    for (int i = 0; i < periods; ++i) {
        z = (random.happens(loss_ppm) ? lost_ : arrived_) * z;
        const double size = z.norm();
        if (size == 0) return 0;
        logarithm += std::log(size);
        z /= size;
    }
    return std::exp(logarithm / periods);
}

double delay_margin_s(const LinearPlant& plant, const RowVectorXd& gain, double period_s,
                      double loss, Stability stability, double most_s) {
    constexpr double look_each_s = 0.001;
    constexpr double within_s = 1e-5;
    constexpr int periods = 20'000;
    constexpr std::uint64_t course = 1;
    const auto at = [&](double delay_s) { return SampledLoop(plant, gain, period_s, delay_s); };
    const auto without_loss = [&](double delay_s) { return at(delay_s).spectral_radius() < 1; };
    const auto in_mean_square = [&](double delay_s) {
        return at(delay_s).mean_square_radius(loss) < 1;
    };
    const auto usually = [&](double delay_s) {
        return at(delay_s).usual_growth(loss, course, periods) < 1;
    };
    double margin_s = 0;
    while (margin_s < most_s && without_loss(margin_s)) margin_s += look_each_s;
    if (margin_s == 0) return 0;
    margin_s = margin_s >= most_s
                   ? most_s
                   : end_of(without_loss, margin_s - look_each_s, margin_s, within_s);
    if (loss == 0) return margin_s;
    // Each kind of stability implies the next: mean square, usual, without losses.
    const double all_s = margin_s;
    if (!in_mean_square(0)) {
        margin_s = 0;
    } else if (!in_mean_square(all_s - within_s)) {
        margin_s = end_of(in_mean_square, 0, all_s, within_s);
    }
    if (stability == Stability::mean_square || usually(all_s - within_s)) {
        return stability == Stability::mean_square ? margin_s : all_s;
    }
    return usually(margin_s) ? end_of(usually, margin_s, all_s, within_s) : margin_s;
}

}  // namespace romano::experiments
