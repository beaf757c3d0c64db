#include "experiments/fleet/picture_feed.h"

#include "experiments/watch/broker_status.h"
#include "romano/server/node_entry.h"

namespace romano::experiments {
namespace {

constexpr std::string_view status_prefix = "$SYS/";

}  // namespace

void tell_picture(FleetPicture& picture, Instant now, std::string_view topic, Bytes data) {
    if (topic.starts_with(echo_prefix)) return;
    if (topic.starts_with(status_prefix)) {
        const auto status = parse_broker_status(as_text(data));
        if (status) picture.on_broker(now, *status);
        return;
    }
    if (const auto id = server::robot_of_entry(topic)) {
        if (data.empty()) return picture.on_entry_deleted(now, *id);
        const auto entry = server::parse_entry(topic, as_text(data));
        if (entry) picture.on_entry(now, *entry);
        return;
    }
    picture.on_message(now, topic, data);
}

}  // namespace romano::experiments
