#include "overlay/radio/layout.h"

#include <cmath>
#include <numbers>

namespace romano::radio {

Place place_on_grid(std::size_t number, std::size_t count, double distance_m) {
    const auto side = static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(count))));
    return {distance_m * static_cast<double>(number % side),
            distance_m * static_cast<double>(number / side)};
}

Place place_around(const Place& router, std::size_t number, std::size_t count) {
    constexpr double metres = 2;
    const double angle =
        2 * std::numbers::pi * static_cast<double>(number) / static_cast<double>(count);
    return {router.x_m + metres * std::cos(angle), router.y_m + metres * std::sin(angle)};
}

}  // namespace romano::radio
