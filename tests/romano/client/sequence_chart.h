// A scripted peer: a test reads like the sequence chart of an exchange.
//
//   chart.publish("pose", "x=1", Qos::at_least_once);
//   chart.sends(Register{...});         the client's next datagram is this one
//   chart.gets(Regack{...});            the broker's answer arrives
//   chart.sends(Publish{...});
//   chart.after(t_retry);               time passes; the client ticks when it wants to
//   chart.tells("published 1");         the client's next event
//
// What is sent or told and not named by the test fails it when the chart ends.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <deque>
#include <string>
#include <string_view>
#include <vector>

#include "romano/client/client.h"
#include "romano/mqttsn/codec.h"

namespace romano::client {

using Octets = std::vector<std::uint8_t>;

inline constexpr std::chrono::seconds t_retry{10};
inline constexpr std::chrono::seconds t_wait{300};
inline constexpr int n_retry = 3;

inline Octets octets_of(const mqttsn::Message& message) {
    Octets octets(mqttsn::encoded_size(message));
    EXPECT_EQ(mqttsn::encode(message, octets), octets.size());
    return octets;
}

/// "PUBLISH 07 0C 20..."
std::string shown(Bytes datagram);
/// "published 1", "received pose x=1 qos 1"
std::string shown(const Event& event);

class SequenceChart {
public:
    /// The client's message ids count from 1.
    explicit SequenceChart(const Timing& timing = {t_retry, t_wait, n_retry});
    ~SequenceChart();
    SequenceChart(const SequenceChart&) = delete;
    SequenceChart& operator=(const SequenceChart&) = delete;

    /// CONNECT and CONNACK.
    void connect(const ConnectOptions& options = {.client_id = "c", .keep_alive = {}});
    /// SUBSCRIBE and SUBACK.
    void subscribe(const mqttsn::TopicRef& topic, mqttsn::TopicId id, mqttsn::Qos granted);
    /// REGISTER and REGACK.
    void register_name(std::string_view name, mqttsn::TopicId id);

    void publish(const mqttsn::TopicRef& topic, std::string_view data, mqttsn::Qos qos,
                 bool retain = false);

    void sends(const mqttsn::Message& message);
    void gets(const mqttsn::Message& message);
    void gets_octets(Bytes datagram);
    void after(Duration time);
    void tells(std::string_view event);
    void is_silent();

    /// For calls of the client: chart.call([](auto& client, auto now, auto& out) {
    /// client.sleep(now, 60s, out); })
    template <typename Call>
    void call(Call&& call) {
        call(client_, now_, out_);
        take_output();
    }

    Client<>& client() { return client_; }
    [[nodiscard]] Instant now() const { return now_; }

private:
    void take_output();

    Client<> client_;
    OutputFor<> out_;
    Instant now_{};
    std::deque<Octets> sent_;
    std::deque<std::string> told_;
};

}  // namespace romano::client
