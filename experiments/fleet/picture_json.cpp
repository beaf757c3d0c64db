#include "experiments/fleet/picture_json.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

namespace romano::experiments {
namespace {

using Json = nlohmann::ordered_json;

double in_ms(Duration time) {
    const double ms = std::chrono::duration<double, std::milli>(time).count();
    return std::round(ms * 100) / 100;
}

Json watch_json(const FleetPicture& picture) {
    Json out{{"broker", picture.watched()}, {"is_linked", picture.is_linked()}};
    if (picture.link_since()) out["since_unix_ms"] = picture.unix_ms(*picture.link_since());
    out["dropped"] = picture.dropped();
    return out;
}

Json recording_json(const RecordingPlace& place) {
    return {{"file", place.file},
            {"start_unix_ms", place.start_unix_ms},
            {"end_unix_ms", place.end_unix_ms},
            {"at_unix_ms", place.at_unix_ms},
            {"speed", place.speed},
            {"is_playing", place.is_playing},
            {"is_seeking", place.is_seeking},
            {"lost", place.lost}};
}

Json cluster_json(const FleetPicture& picture) {
    Json out{{"leader", picture.leader()}, {"term", 0}, {"members", Json::array()}};
    if (const SeenBroker* broker = picture.newest_view()) {
        out["term"] = broker->status.view_term;
        out["members"] = broker->status.view_members;
    }
    return out;
}

Json broker_json(const FleetPicture& picture, const SeenBroker& broker) {
    const BrokerStatus& status = broker.status;
    Json out{{"name", status.name},
             {"alive", status.alive},
             {"leader", status.alive && status.leader},
             {"since_unix_ms", picture.unix_ms(broker.since)},
             {"rank", status.rank},
             {"sessions", status.sessions},
             {"connected", status.connected},
             {"addresses", status.addresses},
             {"cannot_take", status.cannot_take},
             {"longest_turn_ms", static_cast<double>(status.longest_turn_us) / 1e3},
             {"does_not_hear", status.does_not_hear}};
    if (status.condition) out["condition"] = *status.condition;
    if (status.alive && status.cpu_percent) out["cpu_percent"] = *status.cpu_percent;
    if (broker.to_peers_octets_per_s) {
        out["to_peers_octets_per_s"] = std::llround(*broker.to_peers_octets_per_s);
    }
    return out;
}

Json place_json(const Place& place) {
    return {{"x_mm", place.x_mm}, {"y_mm", place.y_mm}, {"heading_mdeg", place.heading_mdeg}};
}

Json path_json(const SeenRobot& robot) {
    Json points = Json::array();
    for (const Place& place : robot.path) points.push_back({place.x_mm, place.y_mm});
    return points;
}

Json robot_json(const FleetPicture& picture, const SeenRobot& robot) {
    const server::NodeEntry& entry = robot.entry;
    Json out{{"robot", entry.id.text()},
             {"state", server::name_of(entry.state)},
             {"home", robot.home},
             {"form", server::name_of(entry.form)},
             {"client", entry.client},
             {"messages_per_s", robot.messages_per_s},
             {"told_per_s", robot.told_per_s}};
    const std::uint64_t heard = robot.heartbeat ? picture.unix_ms(*robot.heartbeat) : 0;
    if (const auto beat = std::max(heard, entry.heartbeat_unix_ms); beat != 0) {
        out["heartbeat_unix_ms"] = beat;
    }
    if (robot.heard) out["heard_unix_ms"] = picture.unix_ms(*robot.heard);
    if (robot.place) out["place"] = place_json(*robot.place);
    if (robot.battery_mv) out["battery_mv"] = *robot.battery_mv;
    return out;
}

Json happening_json(const FleetPicture& picture, const Happening& happening) {
    Json out{{"number", happening.number},
             {"unix_ms", picture.unix_ms(happening.first)},
             {"kind", name_of(happening.kind)}};
    if (!happening.from.empty()) out["from"] = happening.from;
    if (!happening.to.empty()) out["to"] = happening.to;
    if (!happening.what.empty()) out["what"] = happening.what;
    if (happening.robot_count > 0) {
        out["robot_count"] = happening.robot_count;
        out["robots"] = Json::array();
        for (const auto& robot : happening.robots) out["robots"].push_back(robot.text());
    }
    if (happening.took) out["took_ms"] = in_ms(*happening.took);
    if (happening.silence) out["silence_ms"] = in_ms(*happening.silence);
    if (happening.kind == HappeningKind::command) {
        out["confirmed"] = happening.confirmed;
        out["refused"] = happening.refused;
    }
    return out;
}

Json second_json(const FleetPicture& picture, const PaceSecond& second) {
    Json out{{"unix_ms", picture.unix_ms(second.end)}, {"messages", second.messages}};
    if (second.delay) out["delay_ms"] = in_ms(*second.delay);
    if (second.worst_delay) out["worst_delay_ms"] = in_ms(*second.worst_delay);
    if (second.echoes_lost > 0) out["echoes_lost"] = second.echoes_lost;
    return out;
}

Json talks_json(const Talks& talks) {
    Json out = Json::array();
    for (const auto& [ends, talk] : talks.all()) {
        Json& added = out.emplace_back(Json{{"topic", ends.topic}});
        if (!ends.from.empty()) added["from"] = ends.from;
        if (!ends.to.empty()) added["to"] = ends.to;
        added["messages_per_s"] = std::round(talk.messages_per_s() * 10) / 10;
    }
    return out;
}

/// What has changed after `since`; all of it, with paths, when there is no such version.
Json parts(const FleetPicture& picture, std::optional<std::uint64_t> since) {
    const auto is_due = [&](std::uint64_t changed) { return !since || changed > *since; };
    Json out{{"version", picture.version()},     {"watch", watch_json(picture)},
             {"cluster", cluster_json(picture)}, {"brokers", Json::array()},
             {"robots", Json::array()},          {"time_line", Json::array()},
             {"seconds", Json::array()}};
    if (picture.recording()) out["recording"] = recording_json(*picture.recording());
    for (const auto& [name, broker] : picture.brokers()) {
        if (is_due(broker.changed)) out["brokers"].push_back(broker_json(picture, broker));
    }
    for (const auto& [id, robot] : picture.robots()) {
        if (!is_due(robot.changed)) continue;
        Json& added = out["robots"].emplace_back(robot_json(picture, robot));
        if (!since && !robot.path.empty()) added["path"] = path_json(robot);
    }
    for (const Happening& happening : picture.time_line().happenings()) {
        if (is_due(happening.changed)) {
            out["time_line"].push_back(happening_json(picture, happening));
        }
    }
    for (const PaceSecond& second : picture.pace().seconds()) {
        if (is_due(second.changed)) out["seconds"].push_back(second_json(picture, second));
    }
    if (is_due(picture.talks_changed())) out["talks"] = talks_json(picture.talks());
    return out;
}

}  // namespace

nlohmann::ordered_json to_json(const FleetPicture& picture) {
    return parts(picture, std::nullopt);
}

std::optional<nlohmann::ordered_json> changes_since(const FleetPicture& picture,
                                                    std::uint64_t version) {
    const auto left = picture.left_since(version);
    if (!left) return std::nullopt;
    Json out = parts(picture, version);
    out["left"] = Json::array();
    for (const auto& robot : *left) out["left"].push_back(robot.text());
    return out;
}

nlohmann::ordered_json to_json(const FleetPicture& picture, const SeenRobot& robot) {
    Json out = robot_json(picture, robot);
    out["path"] = path_json(robot);
    out["messages"] = Json::array();
    for (const RobotMessage& message : robot.messages) {
        out["messages"].push_back({{"unix_ms", picture.unix_ms(message.at)},
                                   {"to_robot", message.to_robot},
                                   {"times", message.times},
                                   {"topic", message.topic},
                                   {"text", message.text}});
    }
    return out;
}

}  // namespace romano::experiments
