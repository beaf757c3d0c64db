#include "experiments/fleet/fleet_picture.h"

#include <algorithm>
#include <chrono>
#include <variant>

#include "experiments/fleet/shown_text.h"
#include "experiments/operator/message_text.h"
#include "romano/server/server.h"

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;
using message::RomanoId;
using server::NodeState;

// What was there before comes in one burst behind the subscriptions, and is no news.
constexpr auto settles_within = 2s;
// Entries are corrected within a second or two of a take-over, when there are thousands.
constexpr auto death_explains_moves_for = 10s;
constexpr auto return_explains_moves_for = 30s;

constexpr std::size_t most_addresses = 16;
constexpr std::size_t most_members = 128;

void shorten(std::vector<std::string>& texts, std::size_t most) {
    if (texts.size() > most) texts.resize(most);
    for (std::string& text : texts) text = shown_text(text);
}

BrokerStatus shortened(BrokerStatus status) {
    status.name = shown_text(status.name);
    status.view_leader = shown_text(status.view_leader);
    shorten(status.addresses, most_addresses);
    shorten(status.view_members, most_members);
    shorten(status.does_not_hear, most_members);
    status.disagrees.clear();
    return status;
}

server::NodeEntry shortened(server::NodeEntry entry) {
    entry.home = shown_text(entry.home);
    entry.client = shown_text(entry.client);
    return entry;
}

/// Who says so in the message itself.
std::optional<RomanoId> sender_in(std::string_view topic, Bytes data) {
    const auto message = romano_message(topic, data);
    if (!message) return std::nullopt;
    if (const auto* beat = std::get_if<message::Heartbeat>(&*message)) return beat->sender;
    if (const auto* wish = std::get_if<message::ConnectionRequest>(&*message)) return wish->sender;
    return std::nullopt;
}

bool serves_all(const SeenBroker& heir, const std::vector<std::string>& addresses) {
    return std::ranges::all_of(addresses, [&](const std::string& address) {
        return std::ranges::count(heir.status.addresses, address) > 0;
    });
}

void keep_longest(std::optional<Duration>& longest, Duration one) {
    longest = std::max(longest.value_or(one), one);
}

}  // namespace

void FleetPicture::on_link(Instant now, bool is_up) {
    if (is_linked_ == is_up && link_since_) return;
    const std::uint64_t version = next_version();
    if (is_up) {
        settles_at_ = now + settles_within;
        has_settled_ = false;
        for (auto& [id, robot] : robots_) robot.is_confirmed = false;
        if (link_since_) {
            time_line_.add(now, version, {.kind = HappeningKind::watch_back}).took =
                now - *link_since_;
        }
    } else if (link_since_) {
        time_line_.add(now, version, {.kind = HappeningKind::watch_lost});
    }
    is_linked_ = is_up;
    link_since_ = now;
}

void FleetPicture::on_broker(Instant now, const BrokerStatus& told) {
    BrokerStatus status = shortened(told);
    const auto found = brokers_.find(status.name);
    const bool is_new = found == brokers_.end();
    if (is_new && brokers_.size() >= most_brokers) {
        ++dropped_;
        return;
    }
    const std::uint64_t version = next_version();
    SeenBroker& broker = brokers_[status.name];
    if (is_new) {
        broker.since = now;
        if (!is_settling(now) && status.alive) {
            time_line_.add(now, version, {.kind = HappeningKind::broker_found, .to = status.name});
        }
    } else if (broker.status.alive != status.alive) {
        const auto kind = status.alive ? HappeningKind::broker_back : HappeningKind::broker_died;
        Happening& happening = time_line_.add(now, version, {.kind = kind, .to = status.name});
        if (status.alive) happening.took = now - broker.since;
        broker.since = now;
    }
    if (!is_new && broker.status.alive && status.alive) {
        const double seconds = std::chrono::duration<double>(now - broker.told_at).count();
        const std::uint64_t before = broker.status.transport_octets_sent;
        if (seconds > 0.5 && status.transport_octets_sent >= before) {
            broker.to_peers_octets_per_s =
                static_cast<double>(status.transport_octets_sent - before) / seconds;
            broker.told_at = now;
        } else {
            status.transport_octets_sent = before;  // compared with the next one
        }
    } else {
        broker.to_peers_octets_per_s.reset();
        broker.told_at = now;
    }
    if (status.alive) broker.last_served = status.addresses;
    broker.changed = version;
    broker.status = std::move(status);
    look_for_leader(now);
    look_for_heirs(now);
}

const SeenBroker* FleetPicture::newest_view() const {
    const SeenBroker* newest = nullptr;
    for (const auto& [name, broker] : brokers_) {
        if (!broker.status.alive) continue;
        if (newest == nullptr || broker.status.view_term > newest->status.view_term) {
            newest = &broker;
        }
    }
    return newest;
}

void FleetPicture::look_for_leader(Instant now) {
    std::string leads;
    std::uint64_t term = 0;
    for (const auto& [name, broker] : brokers_) {
        const BrokerStatus& status = broker.status;
        if (!status.alive || !status.leader || status.view_term < term) continue;
        leads = name;
        term = status.view_term;
    }
    if (leads == leader_) return;
    if (leads.empty()) {
        leaderless_since_ = now;
    } else if (!is_settling(now) || !leader_.empty() || leaderless_since_) {
        Happening& happening =
            time_line_.add(now, next_version(), {.kind = HappeningKind::leader, .to = leads});
        if (leaderless_since_) happening.took = now - *leaderless_since_;
    }
    if (!leads.empty()) leaderless_since_.reset();
    leader_ = std::move(leads);
}

/// The heir corrects a dead broker's entries when it next looks at them, up to seconds later; who
/// serves the dead one's addresses serves its robots now.
void FleetPicture::look_for_heirs(Instant now) {
    std::map<std::string, std::string> heirs;  // by the dead
    for (const auto& [name, dead] : brokers_) {
        if (dead.status.alive || dead.last_served.empty()) continue;
        for (const auto& [other, broker] : brokers_) {
            if (broker.status.alive && serves_all(broker, dead.last_served)) heirs[name] = other;
        }
    }
    for (auto& [id, robot] : robots_) {
        const auto heir = heirs.find(robot.entry.home);
        const std::string& home = heir == heirs.end() ? robot.entry.home : heir->second;
        if (robot.home != home) set_home(now, robot, home);
    }
}

bool FleetPicture::is_settling(Instant now) const {
    return !settles_at_ || now < *settles_at_;
}

bool FleetPicture::is_dead(const std::string& broker) const {
    const auto found = brokers_.find(broker);
    return found != brokers_.end() && !found->second.status.alive;
}

void FleetPicture::on_entry(Instant now, const server::NodeEntry& told) {
    const auto found = robots_.find(told.id);
    const bool is_new = found == robots_.end();
    if (is_new && robots_.size() >= most_robots) {
        ++dropped_;
        return;
    }
    SeenRobot& robot = robots_[told.id];
    server::NodeEntry entry = shortened(told);
    robot.is_confirmed = true;
    robot.changed = next_version();
    if (is_new) {
        robot.entry = std::move(entry);
        robot.home = robot.entry.home;
        if (is_settling(now)) return;
        time_line_.add(now, version_, {.kind = HappeningKind::robots_found, .to = robot.home},
                       told.id);
        return;
    }
    const NodeState before = robot.entry.state;
    const bool home_is_told = robot.entry.home != entry.home;
    robot.entry = std::move(entry);
    if (before != robot.entry.state) tell_of_state(now, robot, before);
    if (home_is_told && robot.home != robot.entry.home) set_home(now, robot, robot.entry.home);
}

void FleetPicture::tell_of_state(Instant now, const SeenRobot& robot, NodeState before) {
    HappeningKind kind = HappeningKind::robots_back;
    if (robot.entry.state == NodeState::silent) kind = HappeningKind::robots_silent;
    if (robot.entry.state == NodeState::away) kind = HappeningKind::robots_away;
    if (before == NodeState::away && robot.entry.state == NodeState::silent) return;
    time_line_.add(now, next_version(), {.kind = kind}, robot.entry.id);
}

void FleetPicture::set_home(Instant now, SeenRobot& robot, const std::string& home) {
    const std::string from = std::exchange(robot.home, home);
    robot.changed = next_version();
    tell_of_move(now, robot, from);
}

void FleetPicture::tell_of_move(Instant now, SeenRobot& robot, const std::string& from) {
    const auto left = brokers_.find(from);
    const auto came = brokers_.find(robot.home);
    TimeLine::What what{.kind = HappeningKind::roam, .from = from, .to = robot.home};
    if (is_dead(from) && now - left->second.since < death_explains_moves_for) {
        what.kind = HappeningKind::take_over;
    } else if (came != brokers_.end() && now - came->second.since < return_explains_moves_for &&
               left != brokers_.end() && left->second.since < came->second.since) {
        what.kind = HappeningKind::hand_back;
    }
    Happening& happening = time_line_.add(now, robot.changed, std::move(what), robot.entry.id);
    if (happening.kind == HappeningKind::take_over) {
        keep_longest(happening.took, now - left->second.since);
    }
    robot.moved_in = happening.number;
    robot.moved_at = now;
    add_silence(now, robot);
}

void FleetPicture::add_silence(Instant now, const SeenRobot& robot) {
    Happening* happening = time_line_.find(robot.moved_in);
    const auto silence = robot.longest_silence(now);
    if (happening == nullptr || !silence) return;
    if (happening->silence && *happening->silence >= *silence) return;
    happening->silence = silence;
    happening->changed = next_version();
}

void FleetPicture::on_entry_deleted(Instant now, const RomanoId& id) {
    const auto robot = robots_.find(id);
    if (robot != robots_.end()) leave(now, robot);
}

void FleetPicture::leave(Instant now, Robots::iterator robot) {
    const RomanoId id = robot->first;
    robots_.erase(robot);
    const std::uint64_t version = next_version();
    time_line_.add(now, version, {.kind = HappeningKind::robots_left}, id);
    left_.emplace_back(version, id);
    if (left_.size() > most_left) {
        left_known_since_ = left_.front().first;
        left_.pop_front();
    }
}

std::optional<std::vector<RomanoId>> FleetPicture::left_since(std::uint64_t version) const {
    if (version < left_known_since_) return std::nullopt;
    std::vector<RomanoId> found;
    for (const auto& [at, id] : left_) {
        if (at > version && !robots_.contains(id)) found.push_back(id);
    }
    return found;
}

SeenRobot* FleetPicture::find(std::string_view text) {
    const auto id = RomanoId::parse(text);
    const auto found = id ? robots_.find(*id) : robots_.end();
    return found == robots_.end() ? nullptr : &found->second;
}

/// What a robot sends has its id in it, or in its topic as a level among others:
/// `robots/abcd1234/pose`.
SeenRobot* FleetPicture::find_speaker(std::string_view topic, Bytes data) {
    SeenRobot* robot = nullptr;
    if (const auto sender = sender_in(topic, data)) robot = find(sender->text());
    for (std::string_view rest = topic; robot == nullptr && !rest.empty();) {
        const std::size_t end = std::min(rest.find('/'), rest.size());
        robot = find(rest.substr(0, end));
        rest.remove_prefix(std::min(end + 1, rest.size()));
    }
    return robot;
}

void FleetPicture::note_talk(const SeenRobot* speaker, std::string_view topic,
                             const SeenRobot* addressee) {
    const bool has_room =
        talks_.on_message(speaker == nullptr ? "" : speaker->home, shown_topic(topic),
                          addressee == nullptr ? "" : addressee->home);
    if (!has_room) ++dropped_;
}

/// On a robot's own topic it is spoken to.
void FleetPicture::on_message(Instant now, std::string_view topic, Bytes data) {
    pace_.on_message();
    if (SeenRobot* robot = find(topic)) {
        note_talk(nullptr, topic, robot);
        robot->on_said(now, topic, data);
        robot->changed = next_version();
        return;
    }
    SeenRobot* robot = find_speaker(topic, data);
    note_talk(robot, topic, nullptr);
    if (robot == nullptr) return;
    robot->on_heard(now, topic, data);
    robot->changed = next_version();
    if (robot->moved_in != 0) {
        add_silence(now, *robot);
        if (now - robot->moved_at > settles_within) robot->moved_in = 0;
    }
}

std::uint64_t FleetPicture::on_command(Instant now, const std::string& words,
                                       const std::vector<RomanoId>& robots) {
    Happening& command = time_line_.add(
        now, next_version(), {.kind = HappeningKind::command, .what = shown_text(words)});
    command.robot_count = robots.size();
    const std::size_t named = std::min(robots.size(), TimeLine::most_robots_named);
    command.robots.assign(robots.begin(), robots.begin() + static_cast<std::ptrdiff_t>(named));
    return command.number;
}

void FleetPicture::on_command_ended(std::uint64_t command, bool broker_has_it) {
    Happening* happening = time_line_.find(command);
    if (happening == nullptr) return;
    ++(broker_has_it ? happening->confirmed : happening->refused);
    happening->changed = next_version();
}

void FleetPicture::on_played(RecordingPlace place) {
    if (recording_ == place) return;
    recording_ = std::move(place);
    (void)next_version();
}

void FleetPicture::on_tick(Instant now) {
    if (!has_settled_ && !is_settling(now)) settle(now);
    if (!pace_.on_tick(now, version_ + 1)) return;
    const std::uint64_t version = next_version();
    for (auto& [id, robot] : robots_) {
        if (robot.on_second()) robot.changed = version;
    }
    if (talks_.on_second()) talks_changed_ = version;
}

/// Robots that left while nobody watched.
void FleetPicture::settle(Instant now) {
    has_settled_ = true;
    for (auto robot = robots_.begin(); robot != robots_.end();) {
        const auto next = std::next(robot);
        if (!robot->second.is_confirmed) leave(now, robot);
        robot = next;
    }
}

std::uint64_t FleetPicture::unix_ms(Instant instant) const {
    return static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::milliseconds>(
                                          instant.time_since_epoch() + unix_time_at_zero_)
                                          .count());
}

}  // namespace romano::experiments
