// A robot's ROMANO node under any datagrams of its broker, and any data in the messages that reach
// it: what it sends is MQTT-SN, its mailbox keeps its bounds, and it can always be ticked on.

#include <algorithm>
#include <array>
#include <chrono>

#include "romano/client/client.h"
#include "romano/mqttsn/codec.h"
#include "romano/node/node.h"
#include "tests/fuzz/require.h"

using namespace romano;
using namespace std::chrono_literals;

namespace {

class AnyPort final : public node::Port {
public:
    void send(Bytes datagram) override { REQUIRE(mqttsn::decode(datagram).has_value()); }
    void on_message(std::string_view topic, Bytes message) override {
        REQUIRE(message::decode(message).has_value());
        REQUIRE(topic.size() <= 255);  // empty: the broker used a predefined id
    }
};

class Robot {
public:
    Robot() { node_.start(now_, port_); }

    void hear(Bytes datagram) { node_.on_datagram(now_, datagram, port_); }
    template <typename M>
    void hear_message(const M& message) {
        std::array<std::uint8_t, 300> octets{};
        const std::size_t size = mqttsn::encode(message, octets);
        hear(Bytes{octets}.first(size));
    }
    /// Connected, subscribed, acknowledged: commands are carried out.
    void establish() {
        hear_message(mqttsn::Connack{mqttsn::ReturnCode::accepted});
        for (std::uint16_t id = 1; id <= 6; ++id) {
            hear_message(mqttsn::Suback{mqttsn::Qos::at_least_once, mqttsn::TopicId{id},
                                        mqttsn::MsgId{id}, mqttsn::ReturnCode::accepted});
            hear_message(mqttsn::Regack{mqttsn::TopicId{id}, mqttsn::MsgId{id},
                                        mqttsn::ReturnCode::accepted});
            hear_message(mqttsn::Puback{mqttsn::TopicId{id}, mqttsn::MsgId{id},
                                        mqttsn::ReturnCode::accepted});
            hear_publish({0x0C, 0x02});
        }
    }
    void hear_publish(const std::array<std::uint8_t, 2>& data) { hear_publish(Bytes{data}); }
    void hear_publish(Bytes data) {
        hear_message(mqttsn::Publish{.dup = false,
                                     .qos = mqttsn::Qos::at_most_once,
                                     .retain = false,
                                     .topic_type = mqttsn::TopicIdType::normal,
                                     .topic = mqttsn::TopicId{1},
                                     .msg_id = mqttsn::no_msg_id,
                                     .data = data});
    }
    void rest() {
        for (int turns = 0; turns < 3; ++turns) {
            if (node_.next_wakeup() != never) now_ = std::max(now_, node_.next_wakeup());
            node_.on_tick(now_, port_);
        }
        REQUIRE(mailbox_.written - mailbox_.read <= ROMANO_MAILBOX_COMMANDS);
    }

private:
    Instant now_{1s};
    client::Client<client::DeviceLimits> client_{client::Timing{}, 1};
    client::OutputFor<client::DeviceLimits> scratch_;
    romano_mailbox mailbox_{};
    AnyPort port_;
    node::Node node_{client_, scratch_, mailbox_,
                     node::NodeOptions{.id = message::RomanoId::parse("abcd1234").value()}};
};

}  // namespace

// NOLINTNEXTLINE(readability-identifier-naming): the name that libFuzzer calls
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    Bytes input{data, size};
    Robot robot;
    if (!input.empty() && (input[0] & 1U) != 0) robot.establish();
    // Each part: its length and, in one bit, whether it is a datagram or a message's data.
    while (input.size() > 1) {
        const std::size_t most = std::min<std::size_t>(input[0] >> 1U, input.size() - 1);
        const Bytes part = input.subspan(1, most);
        if ((input[0] & 1U) != 0) {
            robot.hear_publish(part);
        } else {
            robot.hear(part);
        }
        input = input.subspan(1 + most);
        robot.rest();
    }
    return 0;
}
