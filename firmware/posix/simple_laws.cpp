#include "firmware/posix/simple_laws.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "firmware/posix/octets.h"

namespace romano::firmware {
namespace {

// Proportional, and so slow that a delay of some hundred milliseconds does no harm.
constexpr double speed_by_distance = 1.0;  // 1/s
constexpr double turn_by_angle = 2.0;      // 1/s
constexpr double most_mm_s = 500;
constexpr double most_deg_s = 180;
constexpr double near_mm = 1;

}  // namespace

std::array<std::uint8_t, 8> octets_of(const Speed& speed) {
    std::array<std::uint8_t, 8> out{};
    put_be32(out.data(), speed.mm_s);
    put_be32(out.data() + 4, speed.deg_s * 1000);
    return out;
}

std::optional<Speed> speed_of(std::span<const std::uint8_t> octets) {
    if (octets.size() != 8) return std::nullopt;
    return Speed{be32(octets, 0), be32(octets, 4) / 1000};
}

std::optional<Leading> Leading::parse(std::uint16_t law, std::span<const std::uint8_t> parameters) {
    Leading out;
    out.law_ = SimpleLaw{law};
    if (out.law_ == SimpleLaw::follow && parameters.size() == 4) {
        out.distance_mm_ = std::max(0.0, be32(parameters, 0));
        return out;
    }
    if (out.law_ == SimpleLaw::go_to && parameters.size() == 8) {
        out.x_mm_ = be32(parameters, 0);
        out.y_mm_ = be32(parameters, 4);
        return out;
    }
    return std::nullopt;
}

Speed Leading::speed_for(const Pose& plant, const Pose& own) const {
    const bool follows = law_ == SimpleLaw::follow;
    const double x = (follows ? own.x_mm : x_mm_) - plant.x_mm;
    const double y = (follows ? own.y_mm : y_mm_) - plant.y_mm;
    const double away = std::hypot(x, y) - distance_mm_;
    if (std::abs(away) < near_mm) return {};
    // Who is too near backs off, and looks where it looked.
    const double bearing = std::atan2(y, x) * 180 / std::numbers::pi;
    const double turn = std::remainder(bearing - plant.heading_deg, 360);
    const double ahead = std::max(0.0, std::cos(turn * std::numbers::pi / 180));
    return {std::clamp(speed_by_distance * away * ahead, -most_mm_s, most_mm_s),
            std::clamp(turn_by_angle * turn, -most_deg_s, most_deg_s)};
}

}  // namespace romano::firmware
