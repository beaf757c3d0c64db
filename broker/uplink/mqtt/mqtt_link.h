// The uplink to an MQTT broker: opened and closed as the member says.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <map>
#include <memory>
#include <string>

#include "broker/core/log_position.h"
#include "broker/uplink/mqtt/mqtt_settings.h"
#include "broker/uplink/uplink_core.h"

namespace romano::uplink {

class MqttThread;

class MqttLink {
public:
    /// Throws std::runtime_error when the settings cannot be used.
    MqttLink(boost::asio::io_context& io, const MqttSettings& settings, LinkEvents events);
    ~MqttLink();
    MqttLink(const MqttLink&) = delete;
    MqttLink& operator=(const MqttLink&) = delete;

    void carry_out(const UplinkAction& action);

private:
    void open();
    void open_or_wait();
    void close();
    void publish(const PublishUp& message);

    boost::asio::io_context& io_;
    MqttSettings settings_;
    LinkEvents events_;
    std::string where_;
    bool is_wanted_ = false;
    bool is_told_ = false;  // that it cannot be opened
    boost::asio::steady_timer pause_;
    std::shared_ptr<MqttThread> thread_;  // null while closed
    std::shared_ptr<MqttThread> closing_;
    std::map<int, broker::LogPosition> on_their_way_;  // by packet id
};

}  // namespace romano::uplink
