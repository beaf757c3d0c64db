#include "bench/flood.h"

#include <algorithm>
#include <chrono>

#include "romano/base/bytes.h"
#include "romano/mqttsn/codec.h"
#include "romano/protection/packet.h"

namespace romano::bench {
namespace {

constexpr std::size_t message_octets = 39;
constexpr std::uint32_t strangers = 1000;
// Who was late does not send more than that at once.
constexpr std::uint64_t most_at_once = 64;

std::vector<std::uint8_t> publish() {
    const std::vector<std::uint8_t> data(message_octets - 7, 'x');
    std::vector<std::uint8_t> datagram(message_octets);
    datagram.resize(mqttsn::encode(
        mqttsn::Publish{false, mqttsn::Qos::at_most_once, false, mqttsn::TopicIdType::normal,
                        mqttsn::TopicId{1}, mqttsn::MsgId{0}, data},
        datagram));
    return datagram;
}

// The first client of a fleet (fleet.h).
constexpr const char* keyed_id = "00000000";

std::vector<std::uint8_t> connect() {
    std::vector<std::uint8_t> datagram(message_octets);
    datagram.resize(
        mqttsn::encode(mqttsn::Connect{false, true, mqttsn::protocol_id, 60, keyed_id}, datagram));
    return datagram;
}

/// Under a key that nobody has, in the name of the first client.
std::vector<std::uint8_t> packet() {
    const std::vector<std::uint8_t> message = publish();
    std::vector<std::uint8_t> datagram(message.size() + protection::most_overhead);
    const protection::Fields fields{protection::sender_id(keyed_id), protection::RunId{0}, 0};
    datagram.resize(protection::write(fields, message, {}, datagram));
    return datagram;
}

/// RFC 6347 section 4.1 and RFC 6655: header, explicit nonce, ciphertext, tag.
std::vector<std::uint8_t> record() {
    constexpr std::size_t body = 8 + message_octets + 8;
    std::vector<std::uint8_t> datagram(13 + body, 'x');
    const std::vector<std::uint8_t> header{23, 0xFE, 0xFD, 0, 1, 0, 0, 0, 0, 0, 0, 0, body};
    std::ranges::copy(header, datagram.begin());
    return datagram;
}

/// RFC 6347 sections 4.1 and 4.2: a ClientHello without a cookie, of a client that has
/// TLS_PSK_WITH_AES_128_CCM_8 (RFC 6655).
std::vector<std::uint8_t> hello() {
    constexpr std::uint8_t body = 2 + 32 + 1 + 1 + 4 + 2;
    std::vector<std::uint8_t> datagram{
        22,   0xFE, 0xFD, 0,    0, 0, 0, 0, 0, 0, 0, 0,    12 + body,  // record
        1,    0,    0,    body, 0, 0, 0, 0, 0, 0, 0, body,             // message
        0xFE, 0xFD};
    datagram.resize(datagram.size() + 32, 'x');  // random
    const std::vector<std::uint8_t> rest{0, 0, 0, 2, 0xC0, 0xA8, 1, 0};
    datagram.insert(datagram.end(), rest.begin(), rest.end());
    return datagram;
}

}  // namespace

Flood::Flood(experiments::MqttsnClients& clients, std::uint32_t number_of_clients, Forgery forgery,
             double per_s)
    : clients_(clients), number_of_clients_(number_of_clients), forgery_(forgery), per_s_(per_s) {
    switch (forgery) {
        case Forgery::publish:
            datagram_ = publish();
            break;
        case Forgery::connect:
            datagram_ = connect();
            break;
        case Forgery::packet:
            datagram_ = packet();
            number_at_ = 1 + 1 + 1 + 1 + 8 + 4;  // behind length, type, flags, scheme, sender, run
            break;
        case Forgery::record:
            datagram_ = record();
            number_at_ = 7;  // the lower 32 of 48 bits
            break;
        case Forgery::hello:
            datagram_ = hello();
            break;
    }
}

void Flood::go_on(Instant now) {
    if (began_ == never) began_ = now;
    const std::chrono::duration<double> since = now - began_;
    const auto due = static_cast<std::uint64_t>(since.count() * per_s_);
    for (std::uint64_t n = 0; sent_ < due && n < most_at_once; ++n) {
        if (number_at_ != 0) {
            ++number_;
            put_be16(datagram_, number_at_, static_cast<std::uint16_t>(number_ >> 16U));
            put_be16(datagram_, number_at_ + 2, static_cast<std::uint16_t>(number_));
        }
        clients_.forge(next_sender(), datagram_);
        ++sent_;
    }
}

std::uint32_t Flood::next_sender() const {
    if (forgery_ == Forgery::packet || forgery_ == Forgery::record) return 0;
    return number_of_clients_ + static_cast<std::uint32_t>(sent_ % strangers);
}

}  // namespace romano::bench
