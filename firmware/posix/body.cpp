#include "firmware/posix/body.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string_view>

#include "firmware/posix/octets.h"

namespace romano::firmware {
namespace {

constexpr std::array<std::string_view, 6> names = {"front", "back",        "left",
                                                   "right", "rotate-left", "rotate-right"};

double radians(double degrees) {
    return degrees * std::numbers::pi / 180.0;
}

}  // namespace

std::optional<Pose> pose_of(std::span<const std::uint8_t> location) {
    if (location.size() != 12) return std::nullopt;
    return Pose{be32(location, 0), be32(location, 4), be32(location, 8) / 1000};
}

void Body::copy(const Pose& from, const Pose& to) {
    // The same step, seen from the other's heading, from here.
    const double turn = radians(pose_.heading_deg - from.heading_deg);
    const double x = to.x_mm - from.x_mm;
    const double y = to.y_mm - from.y_mm;
    pose_.x_mm += x * std::cos(turn) - y * std::sin(turn);
    pose_.y_mm += x * std::sin(turn) + y * std::cos(turn);
    pose_.heading_deg = std::remainder(pose_.heading_deg + to.heading_deg - from.heading_deg, 360);
}

void Body::drive(double mm, double direction_deg) {
    const double angle = radians(pose_.heading_deg + direction_deg);
    pose_.x_mm += mm * std::cos(angle);
    pose_.y_mm += mm * std::sin(angle);
}

void Body::go_on(const Speed& speed, double seconds) {
    // In steps so short that a curve is one.
    constexpr double most_step_s = 0.01;
    for (double left = seconds; left > 0; left -= most_step_s) {
        const double step = std::min(left, most_step_s);
        pose_.heading_deg = std::remainder(pose_.heading_deg + speed.deg_s * step, 360);
        drive(speed.mm_s * step, 0);
    }
}

void Body::carry_out(const romano_command& command) {
    const double amount = romano_command_amount(&command);
    switch (command.type) {
        case 0:
            return drive(amount, 0);
        case 1:
            return drive(amount, 180);
        case 2:
            return drive(amount, 90);
        case 3:
            return drive(amount, -90);
        case 4:
            pose_.heading_deg = std::remainder(pose_.heading_deg + amount / 1000, 360);
            return;
        case 5:
            pose_.heading_deg = std::remainder(pose_.heading_deg - amount / 1000, 360);
            return;
        default:
            return;
    }
}

std::array<std::uint8_t, 12> Body::location() const {
    constexpr double most = 2'147'483'647;
    std::array<std::uint8_t, 12> out{};
    put_be32(out.data(), std::clamp(pose_.x_mm, -most, most));
    put_be32(out.data() + 4, std::clamp(pose_.y_mm, -most, most));
    put_be32(out.data() + 8, pose_.heading_deg * 1000);
    return out;
}

std::string to_text(const romano_command& command) {
    if (command.type < names.size()) {
        return std::string{names[command.type]} + ' ' +
               std::to_string(romano_command_amount(&command)) +
               (command.type < 4 ? " mm" : " mdeg");
    }
    char digits[8];
    std::snprintf(digits, sizeof digits, "0x%04x", unsigned{command.type});
    std::string text = digits;
    for (unsigned i = 0; i < command.size; ++i) {
        std::snprintf(digits, sizeof digits, "%02x", unsigned{command.arguments[i]});
        text += (i == 0 ? " " : "") + std::string{digits};
    }
    return text;
}

}  // namespace romano::firmware
