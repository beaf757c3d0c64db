#include "tests/overlay/member/robot.h"

#include <array>

namespace romano::test {

using namespace std::chrono_literals;
using mqttsn::MsgType;
using mqttsn::Qos;
using mqttsn::TopicIdType;

namespace {

constexpr auto retry = 200ms;

}  // namespace

void Robot::connect(bool clean) {
    ask({.type = MsgType::connect, .flag = clean});
}

void Robot::connect_with_will(const std::string& topic, std::uint16_t keep_alive_s) {
    keep_alive_s_ = keep_alive_s;
    ask({.type = MsgType::connect, .topic = topic, .flag = true});
}

void Robot::subscribe(const std::string& topic, Qos qos) {
    ask({.type = MsgType::subscribe, .topic = topic, .qos = qos});
}

void Robot::publish(const std::string& topic, const std::string& text, Qos qos, bool retain) {
    if (!topic_ids_.contains(topic)) {
        topic_ids_[topic] = mqttsn::no_topic_id;
        ask({.type = MsgType::register_, .topic = topic});
    }
    ask({.type = MsgType::publish, .topic = topic, .text = text, .qos = qos, .flag = retain});
}

void Robot::publish_predefined(mqttsn::TopicId predefined, const std::string& text) {
    ask({.type = MsgType::publish,
         .text = text,
         .qos = Qos::at_least_once,
         .predefined = predefined});
}

void Robot::publish_without_connection(mqttsn::TopicId predefined, const std::string& text) {
    send(mqttsn::Publish{false, Qos::without_connection, false, TopicIdType::predefined, predefined,
                         mqttsn::no_msg_id, as_octets(text)});
}

void Robot::ask(Request request) {
    request.msg_id = mqttsn::MsgId{++last_msg_id_};
    requests_.push_back(std::move(request));
    if (requests_.size() == 1) send_front();
}

void Robot::send_front() {
    while (!requests_.empty()) {
        Request& request = requests_.front();
        request.again_at = now_ + retry;
        const bool again = std::exchange(request.sent, true);
        if (request.type == MsgType::connect) {
            send(mqttsn::Connect{!request.topic.empty(), request.flag, mqttsn::protocol_id,
                                 keep_alive_s_, name_});
        } else if (request.type == MsgType::subscribe) {
            send(mqttsn::Subscribe{again,
                                   request.qos,
                                   request.msg_id,
                                   {TopicIdType::normal, request.topic, mqttsn::no_topic_id}});
        } else if (request.type == MsgType::register_) {
            send(mqttsn::Register{mqttsn::no_topic_id, request.msg_id, request.topic});
        } else if (request.released) {
            send(mqttsn::Pubrel{request.msg_id});
        } else {
            const bool is_predefined = request.topic.empty();
            send(mqttsn::Publish{again, request.qos, request.flag,
                                 is_predefined ? TopicIdType::predefined : TopicIdType::normal,
                                 is_predefined ? request.predefined : topic_ids_.at(request.topic),
                                 request.msg_id, as_octets(request.text)});
            if (request.qos == Qos::at_most_once) {
                requests_.pop_front();
                continue;
            }
        }
        return;
    }
}

void Robot::done() {
    if (requests_.front().type == MsgType::publish) ++acknowledged_;
    requests_.pop_front();
    send_front();
}

void Robot::on_tick(Instant now) {
    now_ = now;
    if (!requests_.empty() && now >= requests_.front().again_at) send_front();
}

void Robot::on_datagram(Bytes datagram) {
    const auto decoded = mqttsn::decode(datagram);
    if (!decoded) return;
    const mqttsn::Message& message = *decoded;
    const auto waits_for = [this](MsgType type, mqttsn::MsgId msg_id) {
        return !requests_.empty() && requests_.front().type == type &&
               requests_.front().msg_id == msg_id;
    };
    if (std::holds_alternative<mqttsn::Connack>(message)) {
        if (!requests_.empty() && requests_.front().type == MsgType::connect) done();
    } else if (std::holds_alternative<mqttsn::Willtopicreq>(message)) {
        send(mqttsn::Willtopic{Qos::exactly_once, false, requests_.front().topic});
    } else if (std::holds_alternative<mqttsn::Willmsgreq>(message)) {
        send(mqttsn::Willmsg{as_octets(name_)});
    } else if (const auto* suback = std::get_if<mqttsn::Suback>(&message)) {
        if (!waits_for(MsgType::subscribe, suback->msg_id)) return;
        if (suback->topic_id != mqttsn::no_topic_id) {
            topic_ids_[requests_.front().topic] = suback->topic_id;
        }
        done();
    } else if (const auto* regack = std::get_if<mqttsn::Regack>(&message)) {
        if (!waits_for(MsgType::register_, regack->msg_id)) return;
        topic_ids_[requests_.front().topic] = regack->topic_id;
        done();
    } else if (const auto* puback = std::get_if<mqttsn::Puback>(&message)) {
        if (waits_for(MsgType::publish, puback->msg_id)) done();
    } else if (const auto* pubrec = std::get_if<mqttsn::Pubrec>(&message)) {
        if (!waits_for(MsgType::publish, pubrec->msg_id)) return;
        requests_.front().released = true;
        send_front();
    } else if (const auto* pubcomp = std::get_if<mqttsn::Pubcomp>(&message)) {
        if (waits_for(MsgType::publish, pubcomp->msg_id)) done();
    } else if (const auto* offered = std::get_if<mqttsn::Register>(&message)) {
        send(mqttsn::Regack{offered->topic_id, offered->msg_id, mqttsn::ReturnCode::accepted});
    } else if (const auto* pubrel = std::get_if<mqttsn::Pubrel>(&message)) {
        unreleased_.erase(pubrel->msg_id);
        send(mqttsn::Pubcomp{pubrel->msg_id});
    } else if (const auto* publish = std::get_if<mqttsn::Publish>(&message)) {
        on_publish(*publish);
    } else if (std::holds_alternative<mqttsn::Disconnect>(message)) {
        ++rejections_;
    }
}

void Robot::on_publish(const mqttsn::Publish& publish) {
    topic_ids_seen_.insert(publish.topic);
    const bool again =
        publish.qos == Qos::exactly_once && !unreleased_.insert(publish.msg_id).second;
    if (!again) received_.emplace_back(as_text(publish.data));
    if (publish.qos == Qos::at_least_once) {
        send(mqttsn::Puback{publish.topic, publish.msg_id, mqttsn::ReturnCode::accepted});
    } else if (publish.qos == Qos::exactly_once) {
        send(mqttsn::Pubrec{publish.msg_id});
    }
}

void Robot::send(const mqttsn::Message& message) {
    ++sent_[mqttsn::type_of(message)];
    std::array<std::uint8_t, 1024> octets{};
    const std::size_t size = mqttsn::encode(message, octets);
    sender_(self_, broker_, Bytes{octets}.first(size));
}

}  // namespace romano::test
