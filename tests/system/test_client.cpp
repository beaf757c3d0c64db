#include "tests/system/test_client.h"

#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "broker/net/socket_address.h"
#include "romano/mqttsn/codec.h"

namespace romano::system {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
using mqttsn::MsgId;
using mqttsn::Qos;
using mqttsn::ReturnCode;

constexpr auto patience = 20s;

template <typename M, typename Rule>
auto is(Rule rule) {
    return [rule](const mqttsn::Message& message) {
        const M* found = std::get_if<M>(&message);
        return found != nullptr && rule(*found);
    };
}

}  // namespace

TestClient::TestClient(const Endpoint& local, const Endpoint& broker, std::string client_id)
    : client_id_(std::move(client_id)), buffer_(mqttsn::max_datagram) {
    open_socket(local, broker);
}

TestClient::TestClient(const Endpoint& local, const Endpoint& broker, const KeyFile& key)
    : packets_(std::make_unique<keys::ClientPackets>(key.path)),
      client_id_(packets_->client_id()),
      buffer_(mqttsn::max_datagram) {
    open_socket(local, broker);
}

void TestClient::open_socket(const Endpoint& local, const Endpoint& broker) {
    const auto from = net::to_socket_address(local);
    const auto to = net::to_socket_address(broker);
    socket_ = socket(from.any.sa_family, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    EXPECT_EQ(bind(socket_, &from.any, from.size), 0);
    // Connected: an answer from any other address than the broker's would not arrive.
    EXPECT_EQ(::connect(socket_, &to.any, to.size), 0);
}

TestClient::~TestClient() {
    close(socket_);
}

bool TestClient::connect(bool clean_session) {
    bool accepted = false;
    const auto connack = is<mqttsn::Connack>([&](const auto& m) {
        accepted = m.return_code == ReturnCode::accepted;
        return true;
    });
    return exchange(mqttsn::Connect{.will = false,
                                    .clean_session = clean_session,
                                    .protocol_id = mqttsn::protocol_id,
                                    .duration_s = 0,
                                    .client_id = client_id_},
                    connack) &&
           accepted;
}

bool TestClient::subscribe(const std::string& filter, Qos qos) {
    const MsgId id = next_msg_id();
    bool accepted = false;
    const auto suback = is<mqttsn::Suback>([&](const auto& m) {
        if (m.msg_id != id) return false;
        accepted = m.return_code == ReturnCode::accepted;
        if (m.topic_id != mqttsn::no_topic_id) topics_[m.topic_id] = filter;
        return true;
    });
    mqttsn::Subscribe request{
        .dup = false, .qos = qos, .msg_id = id, .topic = {mqttsn::TopicIdType::normal, filter, {}}};
    return exchange(request, suback,
                    [request]() mutable {
                        request.dup = true;
                        return request;
                    }) &&
           accepted;
}

std::optional<mqttsn::TopicId> TestClient::register_topic(const std::string& topic) {
    const MsgId id = next_msg_id();
    std::optional<mqttsn::TopicId> given;
    const auto regack = is<mqttsn::Regack>([&](const auto& m) {
        if (m.msg_id != id) return false;
        if (m.return_code == ReturnCode::accepted) given = m.topic_id;
        return true;
    });
    exchange(mqttsn::Register{.topic_id = {}, .msg_id = id, .topic_name = topic}, regack);
    return given;
}

bool TestClient::publish(mqttsn::TopicId topic, const std::string& data, Qos qos, bool retain) {
    const MsgId id = qos == Qos::at_most_once ? mqttsn::no_msg_id : next_msg_id();
    mqttsn::Publish request{.dup = false,
                            .qos = qos,
                            .retain = retain,
                            .topic_type = mqttsn::TopicIdType::normal,
                            .topic = topic,
                            .msg_id = id,
                            .data = as_octets(data)};
    const auto again = [request]() mutable {
        request.dup = true;
        return request;
    };
    bool accepted = true;
    const auto refused = [&](const mqttsn::Message& message) {
        const auto* puback = std::get_if<mqttsn::Puback>(&message);
        if (puback == nullptr || puback->msg_id != id) return false;
        accepted = puback->return_code == ReturnCode::accepted;
        return true;
    };
    switch (qos) {
        case Qos::at_least_once:
            return exchange(request, refused, again) && accepted;
        case Qos::exactly_once: {
            const auto pubrec = is<mqttsn::Pubrec>([&](const auto& m) { return m.msg_id == id; });
            const auto either = [&](const auto& m) { return pubrec(m) || refused(m); };
            if (!exchange(request, either, again) || !accepted) return false;
            return exchange(mqttsn::Pubrel{id},
                            is<mqttsn::Pubcomp>([&](const auto& m) { return m.msg_id == id; }));
        }
        default:
            send(request);
            return true;
    }
}

bool TestClient::ping() {
    return exchange(mqttsn::Pingreq{}, is<mqttsn::Pingresp>([](const auto&) { return true; }));
}

bool TestClient::disconnect() {
    return exchange(mqttsn::Disconnect{}, is<mqttsn::Disconnect>([](const auto&) { return true; }));
}

bool TestClient::exchange(const mqttsn::Message& request, const Matches& answered,
                          const std::function<mqttsn::Message()>& repetition) {
    waiting_for_ = &answered;
    answered_ = false;
    const auto end = Clock::now() + patience;
    for (bool again = false; !answered_ && Clock::now() < end; again = true) {
        send(again && repetition ? repetition() : request);
        run_until([this] { return answered_; }, repeats_after);
    }
    waiting_for_ = nullptr;
    return answered_;
}

bool TestClient::run_until(const std::function<bool()>& done, std::chrono::milliseconds limit) {
    const auto deadline = Clock::now() + limit;
    while (!done()) {
        const auto left =
            std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now());
        if (left.count() <= 0) return false;
        receive(left);
    }
    return true;
}

void TestClient::send(const mqttsn::Message& message) {
    last_sent_ = sealed(message);
    send_octets(last_sent_);
}

std::vector<std::uint8_t> TestClient::sealed(const mqttsn::Message& message) {
    std::vector<std::uint8_t> out(mqttsn::encoded_size(message));
    out.resize(mqttsn::encode(message, out));
    if (!packets_) return out;
    const Bytes packet = packets_->seal(out);
    return {packet.begin(), packet.end()};
}

void TestClient::send_octets(Bytes octets) {
    // A dead broker's port answers with an ICMP error, which is no reason to stop.
    (void)!::send(socket_, octets.data(), octets.size(), 0);
}

bool TestClient::receive(std::chrono::milliseconds limit) {
    pollfd ready{.fd = socket_, .events = POLLIN, .revents = 0};
    if (poll(&ready, 1, static_cast<int>(limit.count())) != 1) return false;
    const ssize_t size = recv(socket_, buffer_.data(), buffer_.size(), 0);
    if (size < 0) return false;
    const MutableBytes datagram = MutableBytes{buffer_}.first(static_cast<std::size_t>(size));
    const Bytes octets = packets_ ? packets_->open(datagram) : Bytes{datagram};
    EXPECT_FALSE(octets.empty()) << "the broker sent what this client's key does not open";
    const auto message = mqttsn::decode(octets);
    EXPECT_TRUE(message) << "the broker sent a malformed datagram";
    if (!message) return false;
    handle(*message);
    return true;
}

void TestClient::handle(const mqttsn::Message& message) {
    if (waiting_for_ != nullptr && !answered_ && (*waiting_for_)(message)) answered_ = true;
    if (std::holds_alternative<mqttsn::Connack>(message) ||
        std::holds_alternative<mqttsn::Suback>(message) ||
        std::holds_alternative<mqttsn::Disconnect>(message)) {
        ++sessions_begun;
    } else if (const auto* name = std::get_if<mqttsn::Register>(&message)) {
        topics_[name->topic_id] = name->topic_name;
        send(mqttsn::Regack{name->topic_id, name->msg_id, ReturnCode::accepted});
    } else if (const auto* publish = std::get_if<mqttsn::Publish>(&message)) {
        handle_publish(*publish);
    } else if (const auto* pubrel = std::get_if<mqttsn::Pubrel>(&message)) {
        if (const auto held = unreleased_.extract(pubrel->msg_id))
            received.push_back(held.mapped());
        send(mqttsn::Pubcomp{pubrel->msg_id});
    }
}

void TestClient::handle_publish(const mqttsn::Publish& publish) {
    ReceivedPublish delivery{topic_name(publish), std::string(as_text(publish.data)), publish.qos,
                             publish.retain, publish.dup};
    switch (publish.qos) {
        case Qos::at_least_once:
            received.push_back(std::move(delivery));
            send(mqttsn::Puback{publish.topic, publish.msg_id, ReturnCode::accepted});
            break;
        case Qos::exactly_once:
            unreleased_.emplace(publish.msg_id, std::move(delivery));
            send(mqttsn::Pubrec{publish.msg_id});
            break;
        default:
            received.push_back(std::move(delivery));
    }
}

std::string TestClient::topic_name(const mqttsn::Publish& publish) const {
    const auto known = topics_.find(publish.topic);
    return known != topics_.end() ? known->second : "unknown topic id";
}

MsgId TestClient::next_msg_id() {
    if (++last_msg_id_ == 0) last_msg_id_ = 1;
    return MsgId{last_msg_id_};
}

}  // namespace romano::system
