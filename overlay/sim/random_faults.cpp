#include "overlay/sim/random_faults.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <utility>

#include "overlay/sim/seed.h"
#include "overlay/sim/settlement.h"

namespace romano::sim {

using namespace std::chrono_literals;

std::optional<Fault> fault_of(std::string_view name) {
    const auto found = std::ranges::find(fault_names, name);
    if (found == fault_names.end()) return std::nullopt;
    return static_cast<Fault>(found - fault_names.begin());
}

RandomFaults::RandomFaults(ClusterWorld& world, const RandomFaultsOptions& options,
                           std::uint64_t seed)
    : world_(world),
      options_(options),
      random_(seed_of(seed, "faults")),
      good_clients_(world.clients().quality()),
      good_peers_(world.peers().options().quality),
      lives_(world, seed) {
    for (Duration* length : {&options_.pause_min, &options_.pause_max, &options_.calm_before_loss,
                             &options_.lasts_max}) {
        *length = world_.in_scale(*length);
    }
}

void RandomFaults::begin() {
    active_ = true;
    watch();
    next();
}

void RandomFaults::end() {
    active_ = false;
    lives_.end();
    heal();
    world_.clients().set_quality(good_clients_);
    world_.peers().set_quality(good_peers_);
    for (std::size_t i = 0; i < world_.broker_count(); ++i) {
        if (world_.broker(i).is_leaving()) world_.broker(i).crash();
        world_.broker(i).go_on();
        world_.broker(i).start();
    }
}

void RandomFaults::next() {
    world_.events().after(random_.between(options_.pause_min, options_.pause_max), [this] {
        if (!active_) return;
        happen(options_.kinds[random_.below(static_cast<std::uint32_t>(options_.kinds.size()))]);
        next();
    });
}

void RandomFaults::watch() {
    if (!active_) return;
    world_.events().after(world_.in_scale(50ms), [this] { watch(); });
    if (apart_ > 0 || disagreement(world_)) {
        calm_since_ = never;
        return;
    }
    if (calm_since_ == never) calm_since_ = world_.now();
    if (!is_calm()) return;
    if (!parted_.empty()) parted_.back().until = std::min(parted_.back().until, world_.now());
    settled_ = world_.broker_count() - down_;
    lost_ = 0;
}

bool RandomFaults::is_calm() const {
    return calm_since_ != never && world_.now() - calm_since_ >= options_.calm_before_loss;
}

bool RandomFaults::may_lose_one() const {
    return apart_ == 0 && lost_ < options_.lost_at_once && lost_ + 1 < settled_;
}

/// Brokers are parted and sent away one thing at a time.
bool RandomFaults::may_happen(Fault fault) const {
    switch (fault) {
        case Fault::crash:
        case Fault::stop:
        case Fault::late:
        case Fault::relapse:
            return may_lose_one();
        case Fault::leave:
        case Fault::partition:
        case Fault::one_way_cut:
        case Fault::starve:
        case Fault::deaf:
            return down_ == 0 && apart_ == 0 && is_calm();
        default:
            return true;
    }
}

void RandomFaults::happen(Fault fault) {
    if (!may_happen(fault)) {
        world_.events().after(world_.in_scale(50ms), [this, fault] {
            if (active_) happen(fault);
        });
        return;
    }
    ++counts_[static_cast<std::size_t>(fault)];
    switch (fault) {
        case Fault::crash:
        case Fault::stop:
        case Fault::late:
        case Fault::relapse:
            return lose(fault);
        case Fault::leave:
            return leave();
        case Fault::partition:
            return part();
        case Fault::one_way_cut:
            return cut_one_way();
        case Fault::bad_links:
            return spoil_links();
        case Fault::roam:
            return lives_.roam();
        case Fault::sleep:
            return lives_.sleep();
        case Fault::die:
            return lives_.die();
        case Fault::share:
            return lives_.start_again();
        case Fault::starve:
            return starve();
        case Fault::deaf:
            return deafen();
    }
}

void RandomFaults::for_a_while(std::uint32_t& lasting, EventQueue::Event undo) {
    ++lasting;
    calm_since_ = never;
    if (&lasting == &apart_) settled_ = 0;  // what a side promised alone is lost with it
    // Short ones are as interesting as long ones: the length's logarithm is uniform.
    const Duration longest = options_.lasts_max / (1U << random_.below(8));
    world_.events().after(random_.between(longest / 2, longest),
                          [this, &lasting, undo = std::move(undo)] {
                              --lasting;
                              calm_since_ = never;  // one that comes back holds nothing yet
                              if (active_) undo();
                          });
}

std::size_t RandomFaults::some_broker() {
    return random_.below(static_cast<std::uint32_t>(world_.broker_count()));
}

/// One or several brokers, at once or one soon after the other.
void RandomFaults::lose(Fault fault) {
    const std::size_t most = std::min(options_.lost_at_once, settled_ - 1) - lost_;
    const std::size_t count = 1 + random_.below(static_cast<std::uint32_t>(most));
    const bool at_once = random_.below(2) == 0;
    for (std::size_t i = 0; i < count; ++i) {
        world_.events().after(at_once ? 0ms : random_.between(0ms, world_.in_scale(500ms)),
                              [this, fault] {
                                  if (active_ && may_lose_one()) lose_one(fault);
                              });
    }
}

void RandomFaults::lose_one(Fault fault) {
    std::size_t victim = some_broker();
    while (!world_.broker(victim).is_running()) victim = (victim + 1) % world_.broker_count();
    ClusterBroker& broker = world_.broker(victim);
    ++lost_;
    fault == Fault::relapse ? relapse(broker, 1 + random_.below(3)) : strike(broker, fault, [] {});
}

/// Undoes it after a while, and does what is to come then.
void RandomFaults::strike(ClusterBroker& broker, Fault fault, EventQueue::Event then) {
    if (fault == Fault::crash) {
        broker.crash();
    } else {
        fault == Fault::stop ? broker.stop() : broker.stop_core();
    }
    for_a_while(down_, [&broker, then = std::move(then)] {
        broker.start();
        broker.go_on();
        then();
    });
}

void RandomFaults::relapse(ClusterBroker& broker, std::uint32_t times) {
    constexpr std::array ways{Fault::crash, Fault::stop, Fault::late};
    strike(broker, ways[random_.below(ways.size())], [this, &broker, times] {
        if (times == 0) return;
        const Duration well =
            random_.between(0ms, world_.in_scale(random_.below(2) == 0 ? 30ms : 200ms));
        world_.events().after(well, [this, &broker, times] {
            if (active_ && broker.is_running()) relapse(broker, times - 1);
        });
    });
}

void RandomFaults::leave() {
    ClusterBroker& broker = world_.broker(some_broker());
    broker.leave();
    for_a_while(apart_, [&broker] {
        broker.crash();
        broker.start();
    });
}

/// The brokers' machine has too much to do: each of them stands still now and then, for longer than
/// its peers wait or not, several of them at once.
void RandomFaults::starve() {
    is_starving_ = true;
    parted_.push_back({world_.now(), never});
    starve_one();
    for_a_while(apart_, [this] { is_starving_ = false; });
}

void RandomFaults::starve_one() {
    if (!active_ || !is_starving_) return;
    ClusterBroker& broker = world_.broker(some_broker());
    if (broker.is_running()) {
        ++apart_;
        broker.stop();
        const Duration still = random_.between(world_.in_scale(5ms), world_.in_scale(200ms));
        world_.events().after(still, [this, &broker] {
            --apart_;
            calm_since_ = never;
            if (active_) broker.go_on();
        });
    }
    const Duration pause = random_.between(world_.in_scale(5ms), world_.in_scale(150ms));
    world_.events().after(pause, [this] { starve_one(); });
}

void RandomFaults::part() {
    std::vector<std::set<std::size_t>> sides(2);
    for (std::size_t i = 0; i < world_.broker_count(); ++i) sides[random_.below(2)].insert(i);
    if (sides[0].empty() || sides[1].empty()) return;
    const bool clients_too = random_.below(2) == 0;
    if (!clients_too) parted_.push_back({world_.now(), never});
    world_.part(sides, clients_too);
    for_a_while(apart_, [this] { heal(); });
}

void RandomFaults::heal() {
    world_.peers().join_all();
    ++apart_;
    const Duration brokers_meet =
        world_.peers().options().match_after_max + world_.in_scale_at_least(100ms);
    world_.events().after(brokers_meet, [this] {
        --apart_;
        world_.clients().cuts().join_all();
    });
}

void RandomFaults::cut_one_way() {
    const std::size_t from = some_broker();
    const std::size_t to = some_broker();
    if (from == to) return;
    parted_.push_back({world_.now(), never});
    world_.cut(from, to);
    for_a_while(apart_, [this] { heal(); });
}

/// Of two, each goes on without one that has fallen silent, and cannot know better.
void RandomFaults::deafen() {
    if (world_.broker_count() == 2) parted_.push_back({world_.now(), never});
    world_.deafen(some_broker());
    ++apart_;
    const Duration detection_time = world_.options().cluster.detection_timeout;
    world_.events().after(random_.between(world_.in_scale(5ms), 5 * detection_time / 2), [this] {
        --apart_;
        calm_since_ = never;
        if (active_) heal();
    });
}

void RandomFaults::spoil_links() {
    LinkQuality clients = good_clients_;
    clients.loss_ppm = random_.below(200'000);
    clients.duplication_ppm = random_.below(50'000);
    clients.late_copy_ppm = random_.below(50'000);
    clients.delay_max += random_.between(0ms, 20ms);
    clients.overtaking = options_.kinds == std::vector{Fault::bad_links};
    LinkQuality peers = good_peers_;
    peers.loss_ppm = random_.below(100'000);
    peers.delay_max += random_.between(0ms, 5ms);
    if (random_.below(2) == 0) world_.clients().set_quality(clients);
    if (random_.below(2) == 0) world_.peers().set_quality(peers);
    world_.events().after(random_.between(world_.in_scale(100ms), options_.lasts_max), [this] {
        world_.clients().set_quality(good_clients_);
        world_.peers().set_quality(good_peers_);
    });
}

}  // namespace romano::sim
