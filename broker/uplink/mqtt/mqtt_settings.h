// Where the MQTT broker is, and who we are there.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "broker/uplink/topic_rules.h"

namespace romano::uplink {

struct MqttSettings {
    std::string host;
    std::uint16_t port = 1883;
    bool tls = false;
    std::string ca_file;  // empty: those of the system
    std::string username;
    std::string password;
    std::string client_id;        // one a network: who leads it takes the session over
    std::vector<Filter> filters;  // to be subscribed to
};

}  // namespace romano::uplink
