#include "tests/system/legacy_robot.h"

#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>

#include "broker/net/socket_address.h"

namespace romano::system {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

// emcute's own numbers, MQTT-SN 1.2 section 5.2.2.
enum : std::uint8_t {
    connect = 0x04,
    connack = 0x05,
    register_type = 0x0A,
    regack = 0x0B,
    publish_type = 0x0C,
    puback = 0x0D,
    subscribe_type = 0x12,
    suback = 0x13,
    pingreq = 0x16,
    pingresp = 0x17,
    disconnect = 0x18,
};

constexpr auto retry = 15s;
constexpr int sendings = 3;
constexpr std::size_t longest_data = 31;

void put16(std::vector<std::uint8_t>& out, std::uint16_t value) {
    out.push_back(static_cast<std::uint8_t>(value >> 8U));
    out.push_back(static_cast<std::uint8_t>(value & 0xFFU));
}

std::uint16_t get16(const std::vector<std::uint8_t>& in, std::size_t at) {
    return static_cast<std::uint16_t>(in[at] << 8U | in[at + 1]);
}

/// With its length in front.
std::vector<std::uint8_t> framed(std::vector<std::uint8_t> body) {
    body.insert(body.begin(), static_cast<std::uint8_t>(body.size() + 1));
    return body;
}

}  // namespace

LegacyRobot::LegacyRobot(const Endpoint& local, const Endpoint& gateway, std::string id)
    : id_(std::move(id)) {
    const auto from = net::to_socket_address(local);
    const auto to = net::to_socket_address(gateway);
    socket_ = socket(from.any.sa_family, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    EXPECT_EQ(bind(socket_, &from.any, from.size), 0);
    EXPECT_EQ(::connect(socket_, &to.any, to.size), 0);
}

LegacyRobot::~LegacyRobot() {
    close(socket_);
}

bool LegacyRobot::establish() {
    Octets body{connect, 0x04, 0x01};  // clean session
    put16(body, 360);
    body.insert(body.end(), id_.begin(), id_.end());
    ++connects;
    if (!request(framed(body), connack) || answer_[2] != 0) return false;
    (void)subscribe(id_);
    (void)subscribe("common");
    while (hellos < 20) {
        publish("init_info", "0" + id_);
        ++hellos;
        if (run_until([this] { return !delivered.empty(); }, 1s)) return true;
    }
    return false;
}

bool LegacyRobot::run_until(const std::function<bool()>& done, std::chrono::milliseconds limit) {
    const auto deadline = Clock::now() + limit;
    for (;;) {
        if (!commands_.empty()) {
            const std::string command = commands_.front();
            commands_.erase(commands_.begin());
            if (command[0] == '1') {
                const std::string topic = command.substr(1);
                if (subscribe(topic)) subscribed.push_back(topic);
            } else {
                const auto length = static_cast<std::size_t>(command[1] - '0');
                publish(command.substr(2, length), command.substr(2 + length));
            }
        }
        if (done()) return true;
        const auto left =
            std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now());
        if (left <= 0ms) return false;
        receive(std::min(left, std::chrono::milliseconds{50}));
    }
}

/// emcute's: one at a time, again unchanged.
bool LegacyRobot::request(const Octets& datagram, std::uint8_t answer) {
    awaited_ = answer;
    answer_.clear();
    for (int sending = 0; sending < sendings && answer_.empty(); ++sending) {
        send(datagram);
        for (const auto until = Clock::now() + retry; answer_.empty() && Clock::now() < until;) {
            receive(50ms);
        }
    }
    awaited_ = 0;
    return !answer_.empty();
}

bool LegacyRobot::subscribe(const std::string& topic) {
    Octets body{subscribe_type, 0x00};
    put16(body, next_id());
    body.insert(body.end(), topic.begin(), topic.end());
    if (!request(framed(body), suback) || answer_[7] != 0) return false;
    subscriptions_[get16(answer_, 3)] = topic;
    return true;
}

std::uint16_t LegacyRobot::topic_id(const std::string& topic) {
    const auto known = topics_.find(topic);
    if (known != topics_.end()) return known->second;
    Octets body{register_type, 0, 0};
    put16(body, next_id());
    body.insert(body.end(), topic.begin(), topic.end());
    if (!request(framed(body), regack) || answer_[6] != 0) return 0;
    return topics_[topic] = get16(answer_, 2);
}

void LegacyRobot::publish(const std::string& topic, const std::string& data) {
    const std::uint16_t id = topic_id(topic);
    if (id == 0) return;
    Octets body{publish_type, 0x00};
    put16(body, id);
    put16(body, next_id());  // not zero, though of QoS 0
    body.insert(body.end(), data.begin(), data.end());
    send(framed(body));
}

void LegacyRobot::send(const Octets& datagram) const {
    (void)::send(socket_, datagram.data(), datagram.size(), 0);
}

bool LegacyRobot::receive(std::chrono::milliseconds limit) {
    pollfd ready{.fd = socket_, .events = POLLIN, .revents = 0};
    if (poll(&ready, 1, static_cast<int>(limit.count())) <= 0) return false;
    Octets packet(512);
    const ssize_t size = recv(socket_, packet.data(), packet.size(), 0);
    if (size < 2) return false;  // nobody listens there for a moment
    packet.resize(static_cast<std::size_t>(size));
    switch (packet[1]) {
        case publish_type:
            on_publish(packet);
            break;
        case pingreq:
            send(framed({pingresp}));
            break;
        case disconnect:
            ++disconnects_ignored;
            break;
        default:
            if (packet[1] == awaited_) answer_ = packet;
            break;
    }
    return true;
}

void LegacyRobot::on_publish(const Octets& packet) {
    const std::uint8_t flags = packet[2];
    const std::uint16_t topic = get16(packet, 3);
    const std::uint16_t message = get16(packet, 5);
    const auto answer = [&](std::uint8_t code) {
        Octets body{puback};
        put16(body, topic);
        put16(body, message);
        body.push_back(code);
        send(framed(body));
        refusals += code != 0 ? 1 : 0;
    };
    constexpr std::uint8_t understood = 0x20 | 0x02;  // QoS 1, short topic names
    if ((flags & ~understood) != 0) return answer(3);
    const auto subscription = subscriptions_.find(topic);
    if (subscription == subscriptions_.end()) return answer(2);
    if ((flags & 0x20) != 0) answer(0);
    std::string data(packet.begin() + 7, packet.end());
    EXPECT_LE(data.size(), longest_data) << "longer data overruns the firmware's memory";
    carry_out(subscription->second, data.substr(0, data.find('\0')));
}

void LegacyRobot::carry_out(const std::string& topic, std::string data) {
    delivered.push_back({topic, data});
    if (data.empty() || data == "ACK") return;
    if (data[0] == '7') movements.push_back(data.substr(1));
    if (data[0] == '1' || data[0] == '2') commands_.push_back(std::move(data));
}

}  // namespace romano::system
