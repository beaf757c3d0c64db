// The invariants of a cluster, judged after every step of every broker, across brokers.
//
// They say what makes the promises P1 to P8 true, so they break before a client sees anything: most
// that break here cost no promise. A broken one is counted, with the first place where it broke;
// whoever runs the simulator says whether that is a failure.
//
// Each is judged in the nearest form that can be seen from outside (sight.h). What README.md calls
// not judged is not here.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "overlay/sim/sight.h"

namespace romano::sim {

enum class Invariant : std::uint8_t {
    one_speaker,
    agreed_end,
    safe_is_safe,
    never_back,
    one_owner,
    as_at_the_seal,
    named_first,
    one_shard,
    one_copy,
    bounded,
};
inline constexpr std::size_t invariant_count = 10;
inline constexpr std::array<std::string_view, invariant_count> invariant_names{
    "I1 one speaker",
    "I2 agreed end",
    "I3 safe is safe",
    "I4 never back",
    "I5 one owner a view",
    "I5s state at the seal",
    "I6 what is named comes first",
    "I7 one shard a client",
    "I7s one copy a home",
    "I8 bounded"};

/// Of each invariant where it broke first; empty: it held.
using Breaches = std::array<std::string, invariant_count>;

class Invariants {
public:
    /// `events_most`: of its own log a broker keeps so many.
    explicit Invariants(std::size_t events_most) : events_most_(events_most) {}

    /// One of the brokers has just done something. Those that broke now and held so far.
    std::vector<Invariant> judge(Instant now, std::span<const Sight> brokers, std::size_t acting);
    [[nodiscard]] const Breaches& breaches() const { return breaches_; }

private:
    void one_speaker(std::span<const Sight> brokers, const Sight& broker);
    void agreed_end(std::span<const Sight> brokers, const Sight& broker);
    void safe_is_safe(std::span<const Sight> brokers, const Sight& broker, const LogCopy& ended);
    void shown_is_held(std::span<const Sight> brokers, const Sight& broker);
    void never_back(const Sight& broker);
    void one_owner(const Sight& broker);
    void as_at_the_seal(std::span<const Sight> brokers, const Sight& broker);
    void named_first(const Sight& broker);
    void one_shard(std::span<const Sight> brokers, const Sight& broker);
    [[nodiscard]] bool have_met(const Sight& one, const Sight& other);
    void note_higher_copies(const Sight& broker);
    [[nodiscard]] bool must_give_way(const Sight& broker, const HigherCopy& to) const;
    void one_copy(const Sight& broker);
    void bounded(std::span<const Sight> brokers, const Sight& broker);

    [[nodiscard]] bool is_broken(Invariant invariant) const;
    void report(Invariant invariant, const std::string& what);

    struct Numbers {
        cluster::ViewNumber view;
        cluster::ViewNumber promised;
    };
    struct Taken {
        cluster::ViewNumber ended_in;
        broker::Seq applied = 0;
    };
    using HolderAndLog = std::pair<broker::LogId, broker::LogId>;

    std::size_t events_most_;
    Instant now_{};
    Breaches breaches_;
    std::vector<Invariant> new_;
    std::map<std::pair<cluster::ViewNumber, broker::LogId>, broker::Seq> ends_;
    std::map<HolderAndLog, Taken> taken_;  // of ended logs
    std::map<broker::LogId, broker::Seq> shown_;
    std::map<std::pair<broker::BrokerId, broker::LogId>, broker::Seq> held_;  // most, ever
    std::map<broker::LogId, Numbers> numbers_;
    std::map<std::pair<cluster::ViewNumber, Endpoint>, broker::LogId> owners_;
    std::map<std::pair<broker::LogId, broker::LogId>, Instant> met_;
    /// Since when each broker knows of those copies, and goes on speaking.
    std::map<broker::LogId, std::vector<std::pair<HigherCopy, Instant>>> higher_;
    std::map<std::pair<broker::LogId, Endpoint>, broker::LogId>
        seals_;  // by whom, of what: for whom
};

}  // namespace romano::sim
