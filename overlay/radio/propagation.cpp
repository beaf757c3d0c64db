#include "overlay/radio/propagation.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace romano::radio {
namespace {

constexpr double nearest_m = 0.1;  // the law says nothing of the near field

}  // namespace

double distance_m(const Place& a, const Place& b) {
    return std::hypot(a.x_m - b.x_m, a.y_m - b.y_m);
}

double mean_dbm(const RadioModel& model, double distance) {
    return model.transmit_dbm - model.loss_at_1m_db -
           10 * model.exponent * std::log10(std::max(distance, nearest_m));
}

double reception_chance(const RadioModel& model, double dbm) {
    // ln 3: three received packets for each lost one, lost_within_db above.
    return 1 / (1 + std::exp(-(dbm - model.half_lost_dbm) / model.lost_within_db * std::log(3.0)));
}

/// In [0, 1).
double RadioLink::uniform() {
    constexpr double steps = 1ULL << 32U;
    return static_cast<double>(random_.next()) / steps;
}

/// Box and Muller.
double RadioLink::normal() {
    const double u = 1 - uniform();
    const double v = uniform();
    return std::sqrt(-2 * std::log(u)) * std::cos(2 * std::numbers::pi * v);
}

double RadioLink::packet_dbm(const Place& a, const Place& b) {
    const double moved = distance_m(a, a_) + distance_m(b, b_);
    const double kept = begun_ ? std::exp(-moved / model_.decorrelation_m) : 0;
    if (kept < 1) {
        shadowing_ =
            kept * shadowing_ + std::sqrt(1 - kept * kept) * model_.shadowing_db * normal();
    }
    begun_ = true;
    a_ = a;
    b_ = b;
    return mean_dbm(model_, distance_m(a, b)) + shadowing_ + model_.fading_db * normal();
}

bool RadioLink::is_received(double dbm) {
    return uniform() < reception_chance(model_, dbm);
}

}  // namespace romano::radio
