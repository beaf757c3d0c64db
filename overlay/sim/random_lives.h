// What robots do besides talking: they roam from broker to broker, sleep and come back, and die.
#pragma once

#include <cstdint>

#include "overlay/sim/cluster_world.h"
#include "romano/base/random.h"

namespace romano::sim {

class RandomLives {
public:
    RandomLives(ClusterWorld& world, std::uint64_t seed);

    /// Some robot, if any is fit for it. Who roams is heard again soon, by its keep-alive; who dies
    /// has left a will.
    void roam();
    void sleep();
    void die();
    /// Sleepers come back, and nobody falls asleep any more.
    void end();

private:
    template <typename IsFit>
    [[nodiscard]] Robot* some_robot(IsFit&& is_fit);

    ClusterWorld& world_;
    Random random_;
    bool active_ = true;
};

}  // namespace romano::sim
