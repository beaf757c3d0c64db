#include "tests/conformance/client.h"

#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "broker/net/socket_address.h"

namespace romano::conformance {
namespace {

using Clock = std::chrono::steady_clock;

unsigned u16(const Octets& octets, std::size_t at) {
    return static_cast<unsigned>(octets.at(at) << 8U | octets.at(at + 1));
}

/// Of that type in the short form, and long enough to be one.
bool is(Msg type, std::size_t at_least, const Octets& datagram) {
    return datagram.size() >= at_least && datagram[0] == datagram.size() &&
           datagram[1] == static_cast<std::uint8_t>(type);
}

}  // namespace

Client::Client(const Endpoint& broker, std::string client_id) : id(std::move(client_id)) {
    const auto to = net::to_socket_address(broker);
    socket_ = socket(to.any.sa_family, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    // Connected: an answer from any other address than the broker's would not arrive.
    EXPECT_EQ(::connect(socket_, &to.any, to.size), 0) << "no socket towards the broker";
}

Client::~Client() {
    if (connected_) says(disconnect());  // leaves nothing behind that a later case would meet
    close(socket_);
}

void Client::says(const Octets& datagram) const {
    EXPECT_EQ(send(socket_, datagram.data(), datagram.size(), 0),
              static_cast<ssize_t>(datagram.size()));
}

Octets Client::next(std::chrono::milliseconds patience) {
    pollfd ready{.fd = socket_, .events = POLLIN, .revents = 0};
    if (poll(&ready, 1, static_cast<int>(patience.count())) != 1) return {};
    Octets datagram(0x10000);
    const ssize_t size = recv(socket_, datagram.data(), datagram.size(), 0);
    if (size < 0) ADD_FAILURE() << id << ": nobody listens at the broker's address";
    datagram.resize(size < 0 ? 0 : static_cast<std::size_t>(size));
    return datagram;
}

Octets Client::next_but_probes() {
    Octets datagram = next();
    while (datagram == pingreq()) datagram = next();
    return datagram;
}

void Client::hears(const Octets& expected) {
    const Octets datagram = expected == pingreq() ? next() : next_but_probes();
    EXPECT_EQ(describe(datagram), describe(expected)) << id << " hears something else";
    EXPECT_TRUE(datagram == expected);
}

void Client::hears_in_time(const Octets& expected, std::chrono::milliseconds patience) {
    const auto end = Clock::now() + patience;
    while (Clock::now() < end) {
        const Octets datagram =
            next(std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now()));
        if (datagram == expected) return;
    }
    ADD_FAILURE() << id << " does not hear " << describe(expected);
}

Client::Registered Client::hears_register(std::string_view name, bool answers) {
    const Octets datagram = next_but_probes();
    if (!is(Msg::register_, 6, datagram)) {
        ADD_FAILURE() << id << " hears " << describe(datagram) << " instead of REGISTER " << name;
        return {};
    }
    const Registered told{static_cast<std::uint16_t>(u16(datagram, 2)),
                          static_cast<std::uint16_t>(u16(datagram, 4))};
    EXPECT_EQ(std::string(datagram.begin() + 6, datagram.end()), name);
    EXPECT_NE(told.topic_id, 0x0000) << "5.3.11: reserved";
    EXPECT_NE(told.topic_id, 0xFFFF) << "5.3.11: reserved";
    EXPECT_NE(told.msg_id, 0) << "a request has a msg id";
    if (answers) says(regack(told.topic_id, told.msg_id, accepted));
    return told;
}

std::uint16_t Client::hears_publish(Flags flags, unsigned topic, std::string_view data) {
    const Octets datagram = next_but_probes();
    const std::size_t msg_id_at = !datagram.empty() && datagram[0] == 0x01 ? 7 : 5;
    const bool carries_msg_id = datagram.size() >= msg_id_at + 2;
    const unsigned msg_id = carries_msg_id ? u16(datagram, msg_id_at) : 0;
    const Octets expected = publish(flags, topic, msg_id, data);
    EXPECT_EQ(describe(datagram), describe(expected)) << id << " hears something else";
    EXPECT_TRUE(datagram == expected);
    const bool is_request = (flags & (qos1 | qos2)) != 0;
    EXPECT_EQ(msg_id != 0, is_request) << "a msg id at QoS 1 and 2, none at QoS 0 (5.3.7)";
    return static_cast<std::uint16_t>(msg_id);
}

void Client::takes(Flags flags, unsigned topic, std::string_view data) {
    const std::uint16_t msg_id = hears_publish(flags, topic, data);
    if ((flags & qos1) != 0) says(puback(topic, msg_id));
    if ((flags & qos2) != 0) {
        says(pubrec(msg_id));
        hears(pubrel(msg_id));
        says(pubcomp(msg_id));
    }
}

void Client::connects(Flags flags, unsigned duration_s) {
    says(connect(id, flags, duration_s));
    hears(connack(accepted));
    connected_ = true;
}

void Client::connects_with_will(std::string_view topic, std::string_view message, Flags will,
                                Flags flags, unsigned duration_s) {
    says(connect(id, flags | with_will, duration_s));
    hears(willtopicreq());
    says(willtopic(topic, will));
    hears(willmsgreq());
    says(willmsg(message));
    hears(connack(accepted));
    connected_ = true;
}

void Client::disconnects() {
    says(disconnect());
    hears(disconnect());
    connected_ = false;
}

void Client::sleeps(unsigned duration_s) {
    says(disconnect_for(duration_s));
    hears(disconnect());
}

std::uint16_t Client::registers(std::string_view name) {
    const unsigned msg_id = next_msg_id();
    says(register_topic(0, msg_id, name));
    const Octets answer = next();
    const unsigned topic_id = is(Msg::regack, 7, answer) ? u16(answer, 2) : 0;
    EXPECT_EQ(describe(answer), describe(regack(topic_id, msg_id, accepted)));
    EXPECT_NE(topic_id, 0x0000) << "5.3.11: reserved";
    EXPECT_NE(topic_id, 0xFFFF) << "5.3.11: reserved";
    return static_cast<std::uint16_t>(topic_id);
}

std::uint16_t Client::subscribes(std::string_view filter, int qos) {
    const unsigned msg_id = next_msg_id();
    says(subscribe(qos_flag(qos), msg_id, filter));
    const Octets answer = next();
    const unsigned topic_id = is(Msg::suback, 8, answer) ? u16(answer, 3) : 0;
    EXPECT_EQ(describe(answer), describe(suback(qos_flag(qos), topic_id, msg_id)));
    return static_cast<std::uint16_t>(topic_id);
}

void Client::publishes(unsigned topic, std::string_view data, int qos, Flags more) {
    const unsigned msg_id = qos > 0 ? next_msg_id() : 0;
    says(publish(qos_flag(qos) | more, topic, msg_id, data));
    if (qos == 1) hears(puback(topic, msg_id));
    if (qos == 2) {
        hears(pubrec(msg_id));
        says(pubrel(msg_id));
        hears(pubcomp(msg_id));
    }
}

}  // namespace romano::conformance
