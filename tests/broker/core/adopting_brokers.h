// A robot's home, an heir that takes its session over, and what passes between them.
#pragma once

#include <gtest/gtest.h>

#include <string_view>
#include <vector>

#include "tests/broker/core/scripted_client.h"

namespace romano::broker {

inline BrokerOptions options_of(std::string_view name) {
    BrokerOptions options = logging_options();
    options.log = {broker_id_of(name), 1};
    return options;
}

/// The session of `client` as a peer of its home would take it over.
inline SessionImage image_of(ScriptedBroker& home, std::string_view client) {
    home.expects_mirror_to_agree();
    return *home.mirror.image(client);
}

/// What another broker published on `cmd`.
inline MessagePtr published_at(const LogPosition& position, std::string_view data,
                               Qos qos = Qos::exactly_once) {
    return MessagePtr{Message{.topic = "cmd",
                              .payload = octets_of(data),
                              .qos = qos,
                              .position = position,
                              .published_at = {}}};
}

class AdoptingBrokers : public ::testing::Test {
protected:
    void takes_over(ScriptedClient& client, const std::vector<MessagePtr>& missed = {}) {
        EXPECT_TRUE(heir.core.adopt(heir.now, image_of(home, client.id), missed, heir.actions));
        heir.drain();
        client.moves_to(heir);
    }

    ScriptedBroker home{options_of("home")};
    ScriptedBroker heir{options_of("heir")};
    ScriptedClient robot{home, "robot"};
    ScriptedClient publisher{home, "publisher"};
};

}  // namespace romano::broker
