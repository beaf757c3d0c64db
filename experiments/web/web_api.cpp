#include "experiments/web/web_api.h"

#include <array>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <utility>

#include "experiments/fleet/picture_json.h"
#include "experiments/web/page_files.h"

namespace romano::experiments {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* json_type = "application/json";

/// What is no UTF-8 in a name becomes a replacement character.
WebAnswer json_answer(unsigned status, const Json& content) {
    return {.status = status,
            .content_type = json_type,
            .body = content.dump(-1, ' ', false, Json::error_handler_t::replace) + '\n'};
}

WebAnswer refusal(unsigned status, const std::string& sentence) {
    return json_answer(status, {{"error", sentence}});
}

WebAnswer no_such_path() {
    return refusal(404, "there is no such page; the API is described in the README of romano web");
}

/// "/api/robots/abcd1234/stop" to "abcd1234" and "stop".
struct RobotPath {
    std::string_view robot;
    std::string_view verb;
};
std::optional<RobotPath> robot_path(std::string_view path) {
    constexpr std::string_view prefix = "/api/robots/";
    if (!path.starts_with(prefix)) return std::nullopt;
    path.remove_prefix(prefix.size());
    const auto slash = path.find('/');
    if (slash == std::string_view::npos) return RobotPath{path, {}};
    return RobotPath{path.substr(0, slash), path.substr(slash + 1)};
}

bool takes_post(std::string_view path) {
    const auto robot = robot_path(path);
    return path == "/api/stop" || path == "/api/recording" || (robot && !robot->verb.empty());
}

struct Movement {
    std::string movement;
    std::string amount;
};
/// Throws std::invalid_argument with one sentence.
Movement movement_in(const std::string& body) {
    const Json object = Json::parse(body, nullptr, false);
    if (!object.is_object()) {
        throw std::invalid_argument(
            R"(the body must be a JSON object: {"movement": "front", "amount": "100mm"})");
    }
    Movement out;
    for (const auto& [key, text] :
         {std::pair{"movement", &out.movement}, {"amount", &out.amount}}) {
        const auto found = object.find(key);
        if (found == object.end() || !found->is_string()) {
            throw std::invalid_argument(std::string{key} + ": must be a text, for example " +
                                        (text == &out.amount ? "100mm" : "front"));
        }
        *text = found->get<std::string>();
    }
    return out;
}

struct PlaybackWish {
    std::optional<bool> plays;
    std::optional<double> speed;
    std::optional<std::uint64_t> at_unix_ms;
};
/// Throws std::invalid_argument with one sentence.
PlaybackWish playback_wish_in(const std::string& body) {
    const Json object = Json::parse(body, nullptr, false);
    PlaybackWish out;
    if (!object.is_object() || object.empty()) {
        throw std::invalid_argument(
            R"(the body must be a JSON object with one of: {"play": true, "speed": 10, "at_unix_ms": 1764100000000})");
    }
    for (const auto& [key, value] : object.items()) {
        if (key == "play" && value.is_boolean()) {
            out.plays = value.get<bool>();
        } else if (key == "speed" && value.is_number() && value >= Playback::slowest &&
                   value <= Playback::fastest) {
            out.speed = value.get<double>();
        } else if (key == "at_unix_ms" && value.is_number_unsigned()) {
            out.at_unix_ms = value.get<std::uint64_t>();
        } else {
            throw std::invalid_argument(
                "allowed are play: true or false, speed: 0.1 to 100, at_unix_ms: milliseconds "
                "since 1970");
        }
    }
    return out;
}

}  // namespace

WebAnswer WebApi::answer(const WebRequest& request) {
    if (names_ && !is_own_host(request.fields.host, *names_)) {
        return refusal(421, "Host: this machine is not called so; write its address");
    }
    const std::string_view path =
        std::string_view{request.target}.substr(0, request.target.find('?'));
    const bool is_get = request.method == "GET" || request.method == "HEAD";
    if (takes_post(path)) {
        if (request.method != "POST") {
            WebAnswer answer = refusal(405, "this takes POST");
            answer.allow = "POST";
            return answer;
        }
        if (const auto objection = objection_to_change(request.fields)) {
            return refusal(403, *objection);
        }
        return post(path, request.body);
    }
    if (!is_get) {
        WebAnswer answer = refusal(405, "this takes GET");
        answer.allow = "GET, HEAD";
        return answer;
    }
    return get(path);
}

WebAnswer WebApi::get(std::string_view path) const {
    if (path == "/api/state") return json_answer(200, to_json(picture_));
    if (path == "/api/events") {
        return {.status = 200,
                .content_type = "text/event-stream",
                .body = {},
                .is_event_stream = true};
    }
    if (const auto found = robot_path(path)) {
        const SeenRobot* robot = robot_of(found->robot);
        if (robot == nullptr) return refusal(404, "no such robot is known");
        return json_answer(200, to_json(picture_, *robot));
    }
    if (path == "/") path = "/index.html";
    for (const PageFile& file : page_files()) {
        if (file.path == path) {
            return {.status = 200,
                    .content_type = std::string{file.content_type},
                    .body = std::string{file.content}};
        }
    }
    return no_such_path();
}

WebAnswer WebApi::post(std::string_view path, const std::string& body) {
    if (path == "/api/recording") return post_to_recording(body);
    if (playback_ != nullptr) {
        return refusal(409, "this is a recording: nothing was said to any robot");
    }
    if (path == "/api/stop") return order(stop_all_orders(picture_));
    const auto [id, verb] = *robot_path(path);
    const SeenRobot* robot = robot_of(id);
    if (robot == nullptr) return refusal(404, "no such robot is known");
    if (verb == "stop") return order(stop_orders(*robot));
    if (verb != "move") return no_such_path();
    try {
        const Movement wanted = movement_in(body);
        return order(move_orders(*robot, wanted.movement, wanted.amount));
    } catch (const std::invalid_argument& refused) {
        return refusal(400, refused.what());
    }
}

WebAnswer WebApi::post_to_recording(const std::string& body) {
    if (playback_ == nullptr) {
        return refusal(404, "this is no recording; romano web --recording FILE shows one");
    }
    try {
        const PlaybackWish wish = playback_wish_in(body);
        if (wish.speed) playback_->set_speed(*wish.speed);
        if (wish.at_unix_ms) playback_->seek(*wish.at_unix_ms);
        if (wish.plays) *wish.plays ? playback_->play() : playback_->pause();
    } catch (const std::invalid_argument& refused) {
        return refusal(400, refused.what());
    }
    return json_answer(202, {{"at_unix_ms", picture_.recording()->at_unix_ms}});
}

WebAnswer WebApi::order(const Orders& orders) {
    if (!picture_.is_linked()) {
        return refusal(503, "no broker answers: nothing was said to any robot");
    }
    const std::uint64_t command = steering_->carry_out(orders);
    return json_answer(202, {{"command", command},
                             {"words", orders.words},
                             {"robots", orders.robots.size()},
                             {"messages", orders.orders.size()}});
}

const SeenRobot* WebApi::robot_of(std::string_view id) const {
    const auto parsed = message::RomanoId::parse(id);
    const auto found = parsed ? picture_.robots().find(*parsed) : picture_.robots().end();
    return found == picture_.robots().end() ? nullptr : &found->second;
}

}  // namespace romano::experiments
