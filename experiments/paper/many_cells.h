// Beyond the paper: brokers on robots, each with a border router and a cell of its own, in one
// cluster whose backbone is a wire. An operator at each broker publishes to the robots of the next
// one's cell in turn, so that every message crosses the backbone.
#pragma once

#include <cstddef>
#include <cstdint>

namespace romano::experiments {

inline constexpr std::size_t robots_of_a_cell = 5;
inline constexpr double metres_between_routers = 30;  // on a square grid

struct ManyCells {
    std::size_t brokers = 2;
    std::size_t channels = 16;  // used in turn: 11, 12, ...
    std::uint32_t router_baud = 230'400;
    std::uint64_t seed = 1;
};

struct CellsRun {
    std::size_t sent = 0;
    std::size_t delivered = 0;
    double delivered_per_s = 0;  // once the queues have had time to fill, while it published
};
[[nodiscard]] CellsRun cells_run(const ManyCells& cells, double rate, std::size_t messages);

}  // namespace romano::experiments
