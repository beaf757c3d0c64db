// Which broker a robot talks to: the nearest of those that discovery finds, by signal strength
// where the radio tells, else by the time that an answer takes. A broker is left for a better one
// only when that is clearly better, so that a robot between two brokers does not swing, and once
// the answers to a search are in, so that it does not move twice. A broker that gets weaker makes
// it look around; one that answers no search any more is forgotten.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "romano/base/bytes.h"
#include "romano/base/endpoint.h"
#include "romano/base/fixed_vector.h"
#include "romano/base/time.h"
#include "romano/client/discovery.h"

namespace romano::firmware {

class BrokerChoice {
public:
    /// After the first answer this long for further ones.
    static constexpr Duration answers_within = to_duration(std::chrono::milliseconds{300});
    static constexpr Duration search_again_every{std::chrono::seconds{10}};
    static constexpr Duration looks_around_within{std::chrono::seconds{1}};
    static constexpr int weaker_db = 3;  // than at the last search: looks around
    static constexpr int clearly_better_db = 6;
    static constexpr std::size_t largest_datagram = client::Discovery::largest_datagram;

    explicit BrokerChoice(std::uint64_t seed)
        : discovery_({.t_searchgw = to_duration(std::chrono::milliseconds{200})}, seed) {}

    /// Asks who is there; also again and again by itself.
    void search(Instant now);
    /// The broker that was chosen does not answer any more.
    void abandon(Instant now, const Endpoint& broker);

    /// `link_dbm`: of the sender; empty when the radio does not tell.
    void on_datagram(Instant now, const Endpoint& from, Bytes datagram,
                     std::optional<int> link_dbm);
    /// The size of a datagram for the discovery group, or 0; `out` holds largest_datagram.
    [[nodiscard]] std::size_t on_tick(Instant now, MutableBytes out);
    [[nodiscard]] Instant next_wakeup() const;
    /// When the answers to the last search are in; `never` before the first, may be in the past.
    [[nodiscard]] Instant decides_at() const { return decides_at_; }

    /// Where to talk to from now on, given where the robot talks to now; empty while unknown. As it
    /// is until decides_at().
    [[nodiscard]] std::optional<Endpoint> choose(Instant now,
                                                 const std::optional<Endpoint>& current) const;

private:
    struct Candidate {
        Endpoint broker;
        std::int16_t cost = 0;  // dB below 0 dBm, or half milliseconds
        std::int16_t cost_when_searched = 0;
        bool by_signal = false;
        bool was_heard = true;  // since the last search
    };

    Candidate* find(const Endpoint& broker);
    [[nodiscard]] std::int16_t answer_time(Instant now) const;
    [[nodiscard]] static bool is_clearly_better(const Candidate& a, const Candidate& b);

    client::Discovery discovery_;
    FixedVector<Candidate, 4> candidates_;
    Instant asked_at_ = never;
    Instant decides_at_ = never;
    Instant search_at_ = never;
};

}  // namespace romano::firmware
