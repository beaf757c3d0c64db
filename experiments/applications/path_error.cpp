#include "experiments/applications/path_error.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace romano::experiments {
namespace {

using firmware::Pose;

/// `place` as seen by who began at `start`.
Pose seen_from(const Pose& start, const Pose& place) {
    const double turn = -start.heading_deg * std::numbers::pi / 180;
    const double x = place.x_mm - start.x_mm;
    const double y = place.y_mm - start.y_mm;
    return {.x_mm = x * std::cos(turn) - y * std::sin(turn),
            .y_mm = x * std::sin(turn) + y * std::cos(turn)};
}

double distance_mm(const Pose& place, const Pose& from, const Pose& to) {
    const double x = to.x_mm - from.x_mm;
    const double y = to.y_mm - from.y_mm;
    const double length = x * x + y * y;
    const double along =
        length == 0 ? 0 : ((place.x_mm - from.x_mm) * x + (place.y_mm - from.y_mm) * y) / length;
    const double part = std::clamp(along, 0.0, 1.0);
    return std::hypot(place.x_mm - from.x_mm - part * x, place.y_mm - from.y_mm - part * y);
}

}  // namespace

PathError path_error(const std::vector<Pose>& path, const std::vector<Pose>& copy) {
    std::vector<Pose> wanted;
    for (const Pose& place : path) wanted.push_back(seen_from(path.front(), place));
    PathError error;
    for (const Pose& each : copy) {
        const Pose place = seen_from(copy.front(), each);
        double nearest = distance_mm(place, wanted.front(), wanted.front());
        for (std::size_t i = 1; i < wanted.size(); ++i) {
            nearest = std::min(nearest, distance_mm(place, wanted[i - 1], wanted[i]));
        }
        error.mean_mm += nearest / static_cast<double>(copy.size());
        error.most_mm = std::max(error.most_mm, nearest);
    }
    return error;
}

double length_mm(const std::vector<Pose>& path) {
    double length = 0;
    for (std::size_t i = 1; i < path.size(); ++i) {
        length += std::hypot(path[i].x_mm - path[i - 1].x_mm, path[i].y_mm - path[i - 1].y_mm);
    }
    return length;
}

}  // namespace romano::experiments
