// Where experiments put border routers and robots.
#pragma once

#include <cstddef>

#include "overlay/radio/propagation.h"

namespace romano::radio {

/// Of one of so many routers: in a square grid, row by row.
[[nodiscard]] Place place_on_grid(std::size_t number, std::size_t count, double distance_m);

/// Of one of so many robots: on a circle of two metres around their router.
[[nodiscard]] Place place_around(const Place& router, std::size_t number, std::size_t count);

}  // namespace romano::radio
