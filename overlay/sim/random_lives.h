// What robots do besides talking: they roam from broker to broker, sleep and come back, die, and
// are started again under another id.
//
// Of robots that have one address together no two talk to one broker: no NAT that keeps source
// ports lets them. None roams to where one of them was that is gone, and one that was started again
// does not roam at all: brokers may take it for that one (overlay/cluster, known limits).
#pragma once

#include <cstdint>
#include <set>

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
    /// Falls silent without a word; another one begins at its address, on its device, with its
    /// tasks.
    void start_again();
    /// Sleepers come back, and nobody falls asleep any more.
    void end();

private:
    template <typename IsFit>
    [[nodiscard]] Robot* some_robot(IsFit&& is_fit);

    enum class Others : std::uint8_t { living, all };
    /// Some broker's, but none to which another robot talks, or talked, from that address.
    [[nodiscard]] Endpoint some_broker_for(const RobotOptions& robot, Others others);

    ClusterWorld& world_;
    Random random_;
    std::set<const Robot*> started_again_;
    bool active_ = true;
};

}  // namespace romano::sim
