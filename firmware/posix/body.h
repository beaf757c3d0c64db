// The body of a simulated robot: carries commands out at once, and knows where it is then.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "romano/node/mailbox.h"

namespace romano::firmware {

/// Where it stands; heading 0 looks along x, positive to the left.
struct Pose {
    double x_mm = 0;
    double y_mm = 0;
    double heading_deg = 0;
};

struct Speed {
    double mm_s = 0;
    double deg_s = 0;
};

class Body {
public:
    Body() = default;
    explicit Body(const Pose& start) : pose_(start) {}

    /// The application's own movements leave it where it is.
    void carry_out(const romano_command& command);
    /// Drives for so long, as somebody who controls it said.
    void go_on(const Speed& speed, double seconds);
    [[nodiscard]] const Pose& pose() const { return pose_; }
    /// As the value of a ROMANO location.
    [[nodiscard]] std::array<std::uint8_t, 12> location() const;

    /// Does what somebody else did who was at `from` and is at `to` now, beginning where it stands.
    void copy(const Pose& from, const Pose& to);

private:
    void drive(double mm, double direction_deg);
    Pose pose_;
};

/// The value of a ROMANO location; empty when the octets are none.
[[nodiscard]] std::optional<Pose> pose_of(std::span<const std::uint8_t> location);

/// "front 100 mm", "rotate-left 90000 mdeg", "0x8001 0a0b".
[[nodiscard]] std::string to_text(const romano_command& command);

}  // namespace romano::firmware
