#include "overlay/ros2/dds/ros2_link.h"

#include <utility>

#include "overlay/ros2/dds/ros2_thread.h"

namespace romano::ros2 {

Ros2Link::Ros2Link(boost::asio::io_context& io, const RosSettings& settings,
                   std::vector<Rule> rules, uplink::LinkEvents events)
    : thread_(std::make_shared<Ros2Thread>(io, settings, std::move(rules), std::move(events))) {
    thread_->start();
}

Ros2Link::~Ros2Link() {
    thread_->stop();
}

void Ros2Link::carry_out(const uplink::UplinkAction& action) {
    if (std::holds_alternative<uplink::OpenLink>(action)) {
        thread_->open();
    } else if (std::holds_alternative<uplink::CloseLink>(action)) {
        thread_->close();
    } else if (const auto* message = std::get_if<uplink::PublishUp>(&action)) {
        thread_->publish(*message);
    }
}

Ros2Facts Ros2Link::facts() const {
    return thread_->facts();
}

uplink::UplinkOptions uplink_options(const std::vector<Rule>& rules) {
    uplink::UplinkOptions out{.network = "romano-ros2",
                              .rules = {},
                              .session = "romano-ros2",
                              .takes_before_sending = true};
    for (const Rule& rule : rules) {
        if (rule.out && rule.retained) out.retained_filters.push_back(rule.romano);
        out.rules.push_back({.pattern = rule.romano,
                             .out = rule.out,
                             .in = rule.in,
                             .most = rule.qos,
                             .local_prefix = {},
                             .remote_prefix = {}});
    }
    return out;
}

}  // namespace romano::ros2
