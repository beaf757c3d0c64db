// How strongly a radio is heard: log-distance path loss with log-normal shadowing (T. S. Rappaport,
// "Wireless Communications", section 4.9), the shadowing correlated along the way as M. Gudmundson
// measured it (Electronics Letters 27(23), 1991): by exp(-d/decorrelation) after d metres.
//
// The numbers are those of an IEEE 802.15.4 radio at 2.4 GHz indoors: 40 dB at one metre, exponent
// 2.7, a CC2538's sensitivity of -97 dBm. Everything is drawn from a seed.
#pragma once

#include <cstdint>

#include "romano/base/random.h"

namespace romano::radio {

struct Place {
    double x_m = 0;
    double y_m = 0;
};
[[nodiscard]] double distance_m(const Place& a, const Place& b);

struct RadioModel {
    double transmit_dbm = 0;
    double loss_at_1m_db = 40;
    double exponent = 2.7;
    double shadowing_db = 4;  // standard deviation
    double decorrelation_m = 2;
    double fading_db = 1;         // of each packet, beside the shadowing
    double half_lost_dbm = -94;   // one packet in two is lost
    double lost_within_db = 1.5;  // and so many dB more make it one in four
};

/// Without shadowing and fading.
[[nodiscard]] double mean_dbm(const RadioModel& model, double distance);
[[nodiscard]] double reception_chance(const RadioModel& model, double dbm);

/// Between two radios that move.
class RadioLink {
public:
    RadioLink(const RadioModel& model, std::uint64_t seed) : model_(model), random_(seed) {}

    /// The strength of a packet sent now from `a` to `b`, or the other way round.
    double packet_dbm(const Place& a, const Place& b);
    /// Whether a packet of that strength is received.
    bool is_received(double dbm);

private:
    [[nodiscard]] double uniform();
    [[nodiscard]] double normal();

    RadioModel model_;
    Random random_;
    bool begun_ = false;
    double shadowing_ = 0;
    Place a_;
    Place b_;
};

}  // namespace romano::radio
