// How well a robot copied another's path: how far the places it was at lie from that path, both
// seen from where each began.
#pragma once

#include <vector>

#include "firmware/posix/body.h"

namespace romano::experiments {

struct PathError {
    double mean_mm = 0;
    double most_mm = 0;
};

/// Both begin with the robot's start and are not empty; the path is straight between its places.
[[nodiscard]] PathError path_error(const std::vector<firmware::Pose>& path,
                                   const std::vector<firmware::Pose>& copy);

[[nodiscard]] double length_mm(const std::vector<firmware::Pose>& path);

}  // namespace romano::experiments
