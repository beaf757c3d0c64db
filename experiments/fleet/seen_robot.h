// One robot as the fleet's watcher sees it: its entry, where it is, what it says.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>

#include "romano/base/bytes.h"
#include "romano/base/time.h"
#include "romano/server/node_entry.h"

namespace romano::experiments {

struct Place {
    std::int32_t x_mm = 0;
    std::int32_t y_mm = 0;
    std::int32_t heading_mdeg = 0;

    friend bool operator==(const Place&, const Place&) = default;
};

struct RobotMessage {
    Instant at;
    std::uint64_t times = 1;  // so far; `at` and `text` are the last one's
    bool to_robot = false;    // on its own topic; else it is the robot's
    std::string topic;
    std::string text;
};

class SeenRobot {
public:
    static constexpr std::size_t most_messages = 32;
    static constexpr std::size_t most_places = 100;

    /// What the robot itself has sent.
    void on_heard(Instant now, std::string_view topic, Bytes data);
    /// What was sent to it.
    void on_said(Instant now, std::string_view topic, Bytes data);
    /// A second is over; true when the rate is another one.
    bool on_second();
    /// The longest that it was not heard, of the last few seconds; empty when it was heard
    /// less than twice.
    [[nodiscard]] std::optional<Duration> longest_silence(Instant now) const;

    std::uint64_t changed = 0;   // the picture's version
    server::NodeEntry entry;     // its texts as they are shown
    std::string home;            // where it is served: the entry's, or by the brokers' addresses
    bool is_confirmed = true;    // told since the watcher has its connection
    std::uint64_t moved_in = 0;  // the happening of its last change of home
    Instant moved_at{};

    std::optional<Instant> heard;
    std::optional<Instant> heartbeat;
    std::optional<Place> place;
    Instant placed_at{};  // when it said so
    std::optional<std::uint16_t> battery_mv;
    std::uint32_t messages_per_s = 0;  // that it sent
    std::uint32_t told_per_s = 0;      // on its own topic
    std::deque<Place> path;            // the oldest first; not each step
    /// The oldest first: of what it says the last on each topic, of what it is told each other
    /// text.
    std::deque<RobotMessage> messages;

private:
    void keep(Instant now, bool to_robot, std::string_view topic, Bytes data);
    void move_to(const Place& next);

    std::uint32_t messages_now_ = 0;
    std::uint32_t told_now_ = 0;
    Duration worst_gap_{0};
    Instant worst_gap_at_{};
};

}  // namespace romano::experiments
