#include "overlay/sim/random_lives.h"

#include <chrono>
#include <vector>

#include "overlay/sim/seed.h"

namespace romano::sim {

using namespace std::chrono_literals;

namespace {

/// Longer than this a robot that only listens would be out of its new broker's sight.
constexpr auto roamer_keep_alive_max = 10s;

}  // namespace

RandomLives::RandomLives(ClusterWorld& world, std::uint64_t seed)
    : world_(world), random_(seed_of(seed, "lives")) {}

template <typename IsFit>
Robot* RandomLives::some_robot(IsFit&& is_fit) {
    std::vector<Robot*> fit;
    for (std::size_t i = 0; i < world_.robot_count(); ++i) {
        Robot& robot = world_.robot(i);
        if (robot.is_connected() && is_fit(robot)) fit.push_back(&robot);
    }
    if (fit.empty()) return nullptr;
    return fit[random_.below(static_cast<std::uint32_t>(fit.size()))];
}

void RandomLives::roam() {
    const Duration longest = world_.in_scale_at_least(roamer_keep_alive_max);
    Robot* robot = some_robot([&](const Robot& candidate) {
        return candidate.options().keep_alive <= longest && !started_again_.contains(&candidate);
    });
    if (robot != nullptr) robot->roam_to(some_broker_for(robot->options(), Others::all));
}

Endpoint RandomLives::some_broker_for(const RobotOptions& robot, Others others) {
    const auto brokers = static_cast<std::uint32_t>(world_.broker_count());
    const Endpoint broker = World::service_address(random_.below(brokers));
    for (std::size_t i = 0; i < world_.robot_count(); ++i) {
        const RobotOptions& other = world_.robot(i).options();
        const bool is_gone = world_.ledger().silenced.contains(other.name);
        if (others == Others::living && is_gone) continue;
        if (other.name != robot.name && other.address == robot.address && other.broker == broker) {
            return robot.broker;
        }
    }
    return broker;
}

void RandomLives::sleep() {
    // A sleeper that misses its time by a lost datagram or two is lost, and no promise is broken.
    Robot* robot =
        some_robot([](const Robot& candidate) { return !candidate.options().will_topic; });
    if (robot == nullptr) return;
    const Duration sleep = world_.in_scale_at_least(std::chrono::seconds{1 + random_.below(2)});
    robot->fall_asleep(std::chrono::duration_cast<std::chrono::seconds>(sleep));
    const Duration back =
        random_.between(world_.in_scale_at_least(200ms), world_.in_scale_at_least(5s));
    world_.events().after(back, [this, robot] {
        if (active_) robot->come_back();
    });
}

void RandomLives::die() {
    Robot* robot = some_robot([this](const Robot& candidate) {
        return world_.ledger().will_topics.contains(candidate.name());
    });
    if (robot != nullptr) robot->switch_off();
}

void RandomLives::start_again() {
    // What its former self sent last must have arrived: nobody can tell it from the next one's.
    constexpr auto last_words_arrive_within = 100ms;
    Robot* robot = some_robot([](const Robot&) { return true; });
    if (robot == nullptr) return;
    robot->switch_off();
    RobotOptions next = robot->options();
    next.name += '-';
    if (next.will_topic) *next.will_topic += '\'';
    next.broker = some_broker_for(next, Others::living);
    Robot& again = world_.add_robot(std::move(next));
    started_again_.insert(&again);
    world_.events().after(random_.between(last_words_arrive_within, 1s), [this, &again] {
        if (!active_) return;
        again.start();
        again.begin_publishing();
    });
}

void RandomLives::end() {
    active_ = false;
    for (std::size_t i = 0; i < world_.robot_count(); ++i) world_.robot(i).come_back();
}

}  // namespace romano::sim
