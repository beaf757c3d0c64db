// What happened in the fleet, in order, the last few hundred: deaths, take-overs, roams, commands.
// What happens to many robots at once is told once, with their number.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "romano/base/time.h"
#include "romano/message/romano_id.h"

namespace romano::experiments {

enum class HappeningKind : std::uint8_t {
    broker_found,
    broker_died,
    broker_back,   // took: how long it was said to be dead
    leader,        // to: who leads now; took: how long nobody did
    take_over,     // from: the dead broker; to: the heir; took: from the word of the death to the
                   // last robot's new home
    hand_back,     // from: the heir; to: the broker that is back
    roam,          // from one living broker to another
    robots_found,  // to: their home
    robots_left,
    robots_silent,
    robots_away,
    robots_back,
    watch_lost,  // the watcher's own broker does not answer
    watch_back,  // took: how long
    command,     // what: in words
};
[[nodiscard]] std::string_view name_of(HappeningKind kind);

struct Happening {
    std::uint64_t number = 0;   // counts up
    std::uint64_t changed = 0;  // the picture's version
    Instant first;
    Instant last;
    HappeningKind kind{};
    std::string from;  // brokers
    std::string to;
    std::string what;
    std::vector<message::RomanoId> robots;  // the first of them
    std::size_t robot_count = 0;
    std::optional<Duration> took;
    std::optional<Duration> silence;  // the longest in which one of these robots was not heard
    std::size_t confirmed = 0;        // of a command: messages that the broker has
    std::size_t refused = 0;
};

class TimeLine {
public:
    static constexpr std::size_t most_happenings = 200;
    /// Who commands often, and robots that come and go, do not push the deaths out.
    static constexpr std::size_t most_of_a_frequent_kind = 40;
    static constexpr std::size_t most_robots_named = 5;

    struct What {
        HappeningKind kind{};
        std::string from = {};
        std::string to = {};
        std::string what = {};
    };
    /// Good until the next one.
    Happening& add(Instant now, std::uint64_t version, What what);
    /// Joins the same that happened to other robots a moment ago.
    Happening& add(Instant now, std::uint64_t version, What what, const message::RomanoId& robot);

    /// Null when it was too long ago.
    [[nodiscard]] Happening* find(std::uint64_t number);
    [[nodiscard]] const std::deque<Happening>& happenings() const { return happenings_; }

private:
    void make_room(HappeningKind kind);

    std::uint64_t last_ = 0;
    std::deque<Happening> happenings_;
};

}  // namespace romano::experiments
