#include "overlay/sim/trace.h"

#include <array>
#include <cstdio>
#include <variant>

#include "overlay/sim/peer_message_text.h"
#include "romano/mqttsn/codec.h"

namespace romano::sim {

namespace {

std::string msg_id_of(const mqttsn::Message& message) {
    return std::visit(
        [](const auto& m) -> std::string {
            if constexpr (requires { m.msg_id; }) {
                return " #" + std::to_string(static_cast<unsigned>(m.msg_id));
            } else {
                return {};
            }
        },
        message);
}

std::string details_of(const mqttsn::Message& message) {
    std::string text = msg_id_of(message);
    if (const auto* publish = std::get_if<mqttsn::Publish>(&message)) {
        text += " qos " + std::to_string(static_cast<unsigned>(publish->qos));
        if (publish->dup) text += " dup";
        if (publish->retain) text += " retain";
        text += " topic " + std::to_string(static_cast<unsigned>(publish->topic)) + " \"";
        text += as_text(publish->data.first(std::min<std::size_t>(publish->data.size(), 24)));
        text += '"';
    } else if (const auto* connect = std::get_if<mqttsn::Connect>(&message)) {
        text += ' ';
        text += connect->client_id;
        if (connect->clean_session) text += " clean";
    } else if (const auto* connack = std::get_if<mqttsn::Connack>(&message)) {
        text += " code " + std::to_string(static_cast<unsigned>(connack->return_code));
    } else if (const auto* puback = std::get_if<mqttsn::Puback>(&message)) {
        text += " code " + std::to_string(static_cast<unsigned>(puback->return_code));
    } else if (const auto* subscribe = std::get_if<mqttsn::Subscribe>(&message)) {
        text += ' ';
        text += subscribe->topic.name;
    } else if (const auto* reg = std::get_if<mqttsn::Register>(&message)) {
        text += ' ';
        text += reg->topic_name;
    }
    return text;
}

}  // namespace

void Trace::append(std::string& line, Bytes datagram) {
    const auto message = mqttsn::decode(datagram);
    if (!message) {
        line += "malformed";
        return;
    }
    line += mqttsn::name_of(mqttsn::type_of(*message));
    line += details_of(*message);
}

void Trace::append(std::string& line, const Endpoint& endpoint) {
    line += to_text(endpoint);
}

void Trace::append(std::string& line, const cluster::ClusterMessage& message) {
    line += to_text(message);
}

std::string Trace::text_of(Instant now) {
    const auto ns = now.time_since_epoch().count();
    std::array<char, 32> text{};
    const int size = std::snprintf(text.data(), text.size(), "%4lld.%06lld",
                                   static_cast<long long>(ns / 1'000'000'000),
                                   static_cast<long long>(ns / 1'000 % 1'000'000));
    return {text.data(), static_cast<std::size_t>(size)};
}

std::string to_text(const Endpoint& endpoint) {
    std::string text;
    for (std::size_t i = 0; i < 4; ++i) {
        if (i > 0) text += '.';
        text += std::to_string(static_cast<unsigned>(endpoint.address[i]));
    }
    return text + ':' + std::to_string(endpoint.port);
}

}  // namespace romano::sim
