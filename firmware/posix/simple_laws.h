// What simulated robots control each other by: the plant tells its location and takes a speed. Two
// laws, both pure: to a point, and to a distance from where the controller itself stands.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "firmware/posix/body.h"

namespace romano::firmware {

/// Numbers of laws in `romano control`.
enum class SimpleLaw : std::uint16_t {
    follow = 1,  // parameters: distance, u32, mm
    go_to = 2,   // parameters: x, y, i32, mm
};

/// As the value of a ROMANO speed: i32 mm/s, i32 millidegrees/s.
[[nodiscard]] std::array<std::uint8_t, 8> octets_of(const Speed& speed);
/// Empty when the octets are none.
[[nodiscard]] std::optional<Speed> speed_of(std::span<const std::uint8_t> octets);

class Leading {
public:
    /// Empty when there is no such law, or the parameters are none of it.
    [[nodiscard]] static std::optional<Leading> parse(std::uint16_t law,
                                                      std::span<const std::uint8_t> parameters);

    /// How the plant at `plant` should drive now, when the controller stands at `own`.
    [[nodiscard]] Speed speed_for(const Pose& plant, const Pose& own) const;

private:
    SimpleLaw law_ = SimpleLaw::follow;
    double distance_mm_ = 0;
    double x_mm_ = 0;
    double y_mm_ = 0;
};

}  // namespace romano::firmware
