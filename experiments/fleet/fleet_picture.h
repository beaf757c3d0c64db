// What is known of a fleet: its brokers and robots, how busy and how fast it is, what happened.
//
// It is told what comes from a broker, decoded, and the time, and has no socket, clock or thread.
// Each change has a number, the version, so that whoever shows the picture can ask for what has
// changed since he last did, and nothing piles up for those who ask rarely. Everything is bounded:
// what comes from the network is kept only as long as a person reads it, and what is more than
// the limits is counted and dropped.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "experiments/fleet/pace.h"
#include "experiments/fleet/seen_robot.h"
#include "experiments/fleet/talks.h"
#include "experiments/fleet/time_line.h"
#include "experiments/watch/broker_status.h"
#include "romano/base/bytes.h"
#include "romano/base/time.h"
#include "romano/message/romano_id.h"
#include "romano/server/node_entry.h"

namespace romano::experiments {

struct SeenBroker {
    std::uint64_t changed = 0;
    BrokerStatus status;                   // its texts as they are shown
    Instant since;                         // of life, or of death
    std::vector<std::string> last_served;  // its addresses, in death those of its life
    std::optional<double> to_peers_octets_per_s;
    Instant told_at;
};

/// Where in a recording the picture is. Times are the recording's.
struct RecordingPlace {
    std::string file;
    std::uint64_t start_unix_ms = 0;
    std::uint64_t end_unix_ms = 0;
    std::uint64_t at_unix_ms = 0;
    double speed = 1;
    bool is_playing = false;
    bool is_seeking = false;        // it comes to a place that somebody chose
    std::vector<std::string> lost;  // what the recording does not have, in sentences

    friend bool operator==(const RecordingPlace&, const RecordingPlace&) = default;
};

class FleetPicture {
public:
    static constexpr std::size_t most_brokers = 128;
    static constexpr std::size_t most_robots = 10'000;
    static constexpr std::size_t most_left = 1'000;  // robots that are remembered to have left

    using Robots = std::map<message::RomanoId, SeenRobot>;
    using Brokers = std::map<std::string, SeenBroker>;

    /// `watched`: the broker that the watcher talks to, for people. `version`: when it takes the
    /// place of another picture, a higher one than that one's last; of older ones nothing is known.
    explicit FleetPicture(Duration unix_time_at_zero, std::string watched = {},
                          std::uint64_t version = 0)
        : unix_time_at_zero_(unix_time_at_zero),
          watched_(std::move(watched)),
          version_(version),
          left_known_since_(version) {}

    /// The watcher's own broker answers, or does no more.
    void on_link(Instant now, bool is_up);
    void on_broker(Instant now, const BrokerStatus& told);
    void on_entry(Instant now, const server::NodeEntry& told);
    void on_entry_deleted(Instant now, const message::RomanoId& id);
    /// Any other message that the watcher hears.
    void on_message(Instant now, std::string_view topic, Bytes data);
    void on_echo(Duration delay) { pace_.on_echo(delay); }
    void on_echo_lost() { pace_.on_echo_lost(); }
    /// A command goes out, in words; the answer numbers it.
    std::uint64_t on_command(Instant now, const std::string& words,
                             const std::vector<message::RomanoId>& robots);
    void on_command_ended(std::uint64_t command, bool broker_has_it);
    /// The picture is that of a recording.
    void on_played(RecordingPlace place);
    /// At least once a second.
    void on_tick(Instant now);

    [[nodiscard]] std::uint64_t version() const { return version_; }
    [[nodiscard]] const std::string& watched() const { return watched_; }
    /// Empty for a fleet that is there now.
    [[nodiscard]] const std::optional<RecordingPlace>& recording() const { return recording_; }
    [[nodiscard]] bool is_linked() const { return is_linked_; }
    [[nodiscard]] std::optional<Instant> link_since() const { return link_since_; }
    [[nodiscard]] const Brokers& brokers() const { return brokers_; }
    [[nodiscard]] const Robots& robots() const { return robots_; }
    /// Empty while nobody leads.
    [[nodiscard]] const std::string& leader() const { return leader_; }
    /// The living broker with the newest view; null when there is none.
    [[nodiscard]] const SeenBroker* newest_view() const;
    [[nodiscard]] const TimeLine& time_line() const { return time_line_; }
    [[nodiscard]] const Pace& pace() const { return pace_; }
    [[nodiscard]] const Talks& talks() const { return talks_; }
    /// The version of their last change.
    [[nodiscard]] std::uint64_t talks_changed() const { return talks_changed_; }
    /// Robots that have left since that version; empty when that is not known so far back.
    [[nodiscard]] std::optional<std::vector<message::RomanoId>> left_since(
        std::uint64_t version) const;
    /// What there was no room for.
    [[nodiscard]] std::uint64_t dropped() const { return dropped_; }
    [[nodiscard]] std::uint64_t unix_ms(Instant instant) const;

private:
    [[nodiscard]] std::uint64_t next_version() { return ++version_; }
    [[nodiscard]] bool is_settling(Instant now) const;
    [[nodiscard]] bool is_dead(const std::string& broker) const;
    void look_for_leader(Instant now);
    void look_for_heirs(Instant now);
    void settle(Instant now);
    void tell_of_state(Instant now, const SeenRobot& robot, server::NodeState before);
    void set_home(Instant now, SeenRobot& robot, const std::string& home);
    void tell_of_move(Instant now, SeenRobot& robot, const std::string& from);
    void add_silence(Instant now, const SeenRobot& robot);
    void leave(Instant now, Robots::iterator robot);
    [[nodiscard]] SeenRobot* find(std::string_view id);
    [[nodiscard]] SeenRobot* find_speaker(std::string_view topic, Bytes data);
    void note_talk(const SeenRobot* speaker, std::string_view topic, const SeenRobot* addressee);

    Duration unix_time_at_zero_;
    std::string watched_;
    std::uint64_t version_;
    std::optional<RecordingPlace> recording_;
    bool is_linked_ = false;
    std::optional<Instant> link_since_;
    std::optional<Instant> settles_at_;
    bool has_settled_ = false;
    Brokers brokers_;
    std::string leader_;
    std::optional<Instant> leaderless_since_;
    Robots robots_;
    std::deque<std::pair<std::uint64_t, message::RomanoId>> left_;
    std::uint64_t left_known_since_;
    TimeLine time_line_;
    Pace pace_;
    Talks talks_;
    std::uint64_t talks_changed_ = 0;
    std::uint64_t dropped_ = 0;
};

}  // namespace romano::experiments
