// What HTTP requests are answered: the page's files, the fleet's picture as JSON, and orders to
// robots, or to the playback of a recording. No socket; README.md describes the API.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "experiments/fleet/fleet_picture.h"
#include "experiments/fleet/orders.h"
#include "experiments/recording/playback.h"
#include "experiments/web/request_rules.h"

namespace romano::experiments {

struct WebRequest {
    std::string method;  // "GET"
    std::string target;  // "/api/robots/abcd1234?x=1"
    RequestFields fields;
    std::string body;
};

struct WebAnswer {
    unsigned status = 200;
    std::string content_type;
    std::string body;
    bool is_event_stream = false;  // it has no body: events follow, until somebody leaves
    std::string allow = {};        // of a 405
};

/// Sends orders to robots.
class Steering {
public:
    /// Numbers the command of the picture's time line.
    virtual std::uint64_t carry_out(const Orders& orders) = 0;

protected:
    ~Steering() = default;
};

class WebApi {
public:
    /// What this machine is called, beside its addresses. Nothing: whatever a certificate proves.
    using Names = std::optional<std::vector<std::string>>;

    WebApi(const FleetPicture& picture, Steering& steering, Names names)
        : picture_(picture), steering_(&steering), names_(std::move(names)) {}
    /// Of a recording: nobody can be steered.
    WebApi(const FleetPicture& picture, Playback& playback, Names names)
        : picture_(picture), playback_(&playback), names_(std::move(names)) {}

    [[nodiscard]] WebAnswer answer(const WebRequest& request);

private:
    [[nodiscard]] WebAnswer get(std::string_view path) const;
    [[nodiscard]] WebAnswer post(std::string_view path, const std::string& body);
    [[nodiscard]] WebAnswer post_to_recording(const std::string& body);
    [[nodiscard]] WebAnswer order(const Orders& orders);
    [[nodiscard]] const SeenRobot* robot_of(std::string_view id) const;

    const FleetPicture& picture_;
    Steering* steering_ = nullptr;
    Playback* playback_ = nullptr;
    Names names_;
};

}  // namespace romano::experiments
