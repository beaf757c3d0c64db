// What a member tells people about a broker: one retained message `$SYS/brokers/<name>` each, a
// JSON object, so that `romano brokers` is a plain MQTT-SN client.
#pragma once

#include <string>

#include "overlay/cluster/agreement/settings_comparison.h"
#include "overlay/cluster/messages.h"

namespace romano::overlay {

struct BrokerStatus {
    const cluster::Beacon& beacon;  // the broker's newest
    bool alive = false;
    bool leads = false;
    const cluster::View& view;                     // the teller's
    const std::vector<std::string>& member_names;  // of the view, in its order
    std::string leader_name;                       // of the view
    std::string teller_name = {};
    std::string rights = {};                            // empty: not known
    std::vector<std::string> does_not_hear = {};        // living members of the view, by name
    std::vector<cluster::Difference> differences = {};  // from the teller's settings
};

[[nodiscard]] std::string status_topic(const std::string& name);
[[nodiscard]] std::string to_json(const BrokerStatus& status);
/// "10.0.0.1:1883", "[fe80::1%2]:1883".
[[nodiscard]] std::string to_text(const Endpoint& endpoint);

}  // namespace romano::overlay
