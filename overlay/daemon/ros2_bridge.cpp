#include "overlay/daemon/ros2_bridge.h"

#include <fstream>
#include <iterator>
#include <string>
#include <utility>

#include "broker/daemon/refusal.h"
#include "broker/net/interface_address.h"
#include "overlay/dds/entity.h"

namespace romano::daemon {

std::vector<ros2::Rule> read_ros2_rules(const std::string& file) {
    std::ifstream in(file);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    if (!in) refuse_option("ros2-rules", file, "the file cannot be read; give a file of rules");
    auto rules = ros2::parse_rules(text);
    if (!rules) refuse_option("ros2-rules", file, rules.error());
    return std::move(rules.value());
}

Ros2Bridge::Ros2Bridge(boost::asio::io_context& io, const Ros2Settings& settings,
                       std::vector<ros2::Rule> rules, uplink::LinkEvents events) {
    const bool over_ipv6 =
        net::interface_address(settings.interface).family == Endpoint::Family::ipv6;
    const ros2::Release release =
        settings.release == "humble" ? ros2::Release::humble : ros2::Release::iron;
    try {
        link_ = std::make_unique<ros2::Ros2Link>(
            io, ros2::RosSettings{settings.domain, settings.interface, over_ipv6, release},
            std::move(rules), std::move(events));
    } catch (const dds::DdsError& error) {
        throw Refusal("--ros2-domain '" + std::to_string(settings.domain) + "': cannot be joined" +
                      (settings.interface.empty() ? "" : " on " + settings.interface) + " (" +
                      error.what() + "); choose another --ros2-interface");
    }
}

void Ros2Bridge::add_metrics(metrics::Page& page, const overlay::UplinkFacts& member) const {
    const ros2::Ros2Facts facts = link_->facts();
    page.gauge("romano_ros2_is_open", "1 when this broker bridges to ROS 2.",
               facts.is_open ? 1 : 0);
    page.gauge("romano_ros2_endpoints", "Publishers and subscriptions in ROS 2.",
               static_cast<double>(facts.endpoints));
    page.counter("romano_ros2_messages_total", "Messages over the bridge to ROS 2.",
                 facts.counters.to_ros, {{"direction", "out"}});
    page.counter("romano_ros2_messages_total", "Messages over the bridge to ROS 2.",
                 facts.counters.from_ros, {{"direction", "in"}});
    const auto drop = [&page](const char* reason, std::uint64_t value) {
        page.counter("romano_ros2_drops_total", "Messages of either way that went no further.",
                     value, {{"reason", reason}});
    };
    drop("unfit", facts.counters.unfit);
    drop("bad_name", facts.counters.bad_name);
    drop("too_many_endpoints", facts.counters.too_many);
    drop("overflow_out", facts.overflow_out);
    drop("overflow_in", facts.overflow_in);
    drop("not_written", facts.not_written);
    drop("duplicate", member.counters.duplicates);
    drop("too_long", member.too_long);
    drop("not_open", member.counters.dropped);
}

}  // namespace romano::daemon
