// Faults at random times: brokers crash, stop and leave, links are cut and grow bad.
//
// Brokers that are parted with their clients meet again before the clients hear both sides: a
// beacon time is enough for brokers to fall silent, and who hears a stale home before that may get
// a message twice (overlay/cluster, known limits).
//
// It keeps to what P2 is about: once the cluster has been calm for a while, what was acknowledged
// has reached the peers that promise it, and from then on at most `acks` of those brokers crash
// until it is calm again: at once, while it has not settled after another crash, or while one comes
// back.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "overlay/sim/cluster_world.h"
#include "overlay/sim/random_lives.h"
#include "romano/base/random.h"

namespace romano::sim {

enum class Fault : std::uint8_t {
    crash,
    stop,
    leave,
    partition,
    one_way_cut,
    bad_links,
    roam,  // these three are robots' (random_lives.h)
    sleep,
    die,
    // Only when asked for:
    late,     // a broker's core: it stands still while its process lives
    starve,   // of processor time, all of them: short stops, several at once
    relapse,  // a broker crashes or stops again just after it came back, a few times
    deaf,   // what comes to a broker from its peers waits, for up to two and a half detection times
    share,  // robots have one address together (random_lives.h), and are started again under other
            // ids
};
inline constexpr std::size_t fault_kinds = 14;
inline constexpr std::array<std::string_view, fault_kinds> fault_names{
    "crash", "stop", "leave", "partition", "one-way-cut", "bad-links", "roam",
    "sleep", "die",  "late",  "starve",    "relapse",     "deaf",      "share"};
using FaultCounts = std::array<std::uint32_t, fault_kinds>;

[[nodiscard]] constexpr std::string_view name_of(Fault fault) {
    return fault_names[static_cast<std::size_t>(fault)];
}
[[nodiscard]] std::optional<Fault> fault_of(std::string_view name);

struct RandomFaultsOptions {
    std::vector<Fault> kinds{Fault::crash,     Fault::stop,        Fault::leave,
                             Fault::partition, Fault::one_way_cut, Fault::bad_links,
                             Fault::roam,      Fault::sleep,       Fault::die};
    std::size_t lost_at_once = 1;  // at most
    // Where silence of 100 ms means death; elsewhere in proportion (ClusterWorld::in_scale).
    Duration pause_min{std::chrono::milliseconds{200}};  // from one fault to the next
    Duration pause_max{std::chrono::seconds{2}};
    Duration calm_before_loss{std::chrono::milliseconds{500}};
    Duration lasts_max{std::chrono::seconds{3}};
};

class RandomFaults {
public:
    RandomFaults(ClusterWorld& world, const RandomFaultsOptions& options, std::uint64_t seed);

    void begin();
    /// All faults end: brokers run, links are good.
    void end();

    /// While brokers were parted and their clients were not, while they starved, and while one of
    /// two was deaf.
    [[nodiscard]] const std::vector<Span>& parted() const { return parted_; }
    /// How often each kind happened.
    [[nodiscard]] const FaultCounts& counts() const { return counts_; }

private:
    void next();
    void happen(Fault fault);
    void lose(Fault fault);
    void lose_one(Fault fault);
    void strike(ClusterBroker& broker, Fault fault, EventQueue::Event then);
    void relapse(ClusterBroker& broker, std::uint32_t times);
    void leave();
    void starve();
    void starve_one();
    void part();
    void cut_one_way();
    void deafen();
    void spoil_links();
    void for_a_while(std::uint32_t& lasting, EventQueue::Event undo);
    void heal();
    [[nodiscard]] std::size_t some_broker();
    /// Looks whether the cluster has come to rest.
    void watch();
    [[nodiscard]] bool is_calm() const;
    [[nodiscard]] bool may_happen(Fault fault) const;
    [[nodiscard]] bool may_lose_one() const;

    ClusterWorld& world_;
    RandomFaultsOptions options_;
    Random random_;
    LinkQuality good_clients_;
    LinkQuality good_peers_;
    FaultCounts counts_{};
    bool active_ = false;
    RandomLives lives_;
    std::uint32_t down_ = 0;   // crashed and stopped brokers
    std::uint32_t apart_ = 0;  // other faults that keep brokers from each other, now
    bool is_starving_ = false;
    Instant calm_since_ = never;
    std::size_t settled_ = 0;  // brokers that agreed when it was calm last
    std::size_t lost_ = 0;     // of them, since
    std::vector<Span> parted_;
};

}  // namespace romano::sim
