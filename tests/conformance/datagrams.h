// Datagrams octet by octet from MQTT-SN 1.2 section 5.4, as a client writes them and as a broker
// must write them. Written by hand: nothing here is shared with the broker's own codec.
#pragma once

#include <cstddef>
#include <cstdint>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

namespace romano::conformance {

using Octets = std::vector<std::uint8_t>;

/// Section 5.2.2.
enum class Msg : std::uint8_t {
    advertise = 0x00,
    searchgw = 0x01,
    gwinfo = 0x02,
    connect = 0x04,
    connack = 0x05,
    willtopicreq = 0x06,
    willtopic = 0x07,
    willmsgreq = 0x08,
    willmsg = 0x09,
    register_ = 0x0A,  // NOLINT(readability-identifier-naming): "register" is a keyword
    regack = 0x0B,
    publish = 0x0C,
    puback = 0x0D,
    pubcomp = 0x0E,
    pubrec = 0x0F,
    pubrel = 0x10,
    subscribe = 0x12,
    suback = 0x13,
    unsubscribe = 0x14,
    unsuback = 0x15,
    pingreq = 0x16,
    pingresp = 0x17,
    disconnect = 0x18,
    willtopicupd = 0x1A,
    willtopicresp = 0x1B,
    willmsgupd = 0x1C,
    willmsgresp = 0x1D,
    encapsulated = 0xFE,
};

/// Section 5.3.10.
enum Code : std::uint8_t { accepted = 0, congestion = 1, invalid_topic_id = 2, not_supported = 3 };

/// Section 5.3.4: the bits of the flags octet, to be added up. QoS -1 is qos_minus_1.
enum Flag : std::uint8_t {
    no_flags = 0x00,
    dup = 0x80,
    qos1 = 0x20,
    qos2 = 0x40,
    qos_minus_1 = 0x60,
    retain = 0x10,
    with_will = 0x08,
    clean = 0x04,
    predefined = 0x01,
    short_name = 0x02,
    reserved_type = 0x03,
};
using Flags = unsigned;

inline Flags qos_flag(int qos) {
    return static_cast<Flags>(qos & 3) << 5U;
}

/// The two octets in which a PUBLISH names its topic: an id, or a short name's characters.
inline std::uint16_t short_topic(std::string_view two) {
    return static_cast<std::uint16_t>(static_cast<std::uint8_t>(two[0]) << 8U |
                                      static_cast<std::uint8_t>(two[1]));
}

/// What stands behind the message type, part by part.
class Body {
public:
    Body& u8(unsigned value) {
        octets_.push_back(static_cast<std::uint8_t>(value));
        return *this;
    }
    Body& u16(unsigned value) { return u8(value >> 8U).u8(value & 0xFFU); }
    Body& text(std::string_view text) {
        octets_.insert(octets_.end(), text.begin(), text.end());
        return *this;
    }
    Body& octets(const Octets& octets) {
        octets_.insert(octets_.end(), octets.begin(), octets.end());
        return *this;
    }

    /// Section 5.2.1: the short form of the length where it fits.
    [[nodiscard]] Octets as(Msg type) const {
        return octets_.size() + 2 < 256 ? framed({}, octets_.size() + 2, type) : in_long_form(type);
    }
    [[nodiscard]] Octets in_long_form(Msg type) const {
        const std::size_t size = octets_.size() + 4;
        return framed({0x01, static_cast<std::uint8_t>(size >> 8U)}, size & 0xFFU, type);
    }

private:
    [[nodiscard]] Octets framed(Octets front, std::size_t length, Msg type) const {
        front.push_back(static_cast<std::uint8_t>(length));
        front.push_back(static_cast<std::uint8_t>(type));
        front.insert(front.end(), octets_.begin(), octets_.end());
        return front;
    }

    Octets octets_;
};

inline Octets searchgw(unsigned radius) {
    return Body{}.u8(radius).as(Msg::searchgw);
}
inline Octets connect(std::string_view client_id, Flags flags = clean, unsigned duration_s = 0,
                      unsigned protocol_id = 1) {
    return Body{}.u8(flags).u8(protocol_id).u16(duration_s).text(client_id).as(Msg::connect);
}
inline Octets connack(Code code) {
    return Body{}.u8(code).as(Msg::connack);
}
inline Octets willtopicreq() {
    return Body{}.as(Msg::willtopicreq);
}
inline Octets willtopic(std::string_view topic, Flags flags = no_flags) {
    return Body{}.u8(flags).text(topic).as(Msg::willtopic);
}
inline Octets empty_willtopic() {
    return Body{}.as(Msg::willtopic);
}
inline Octets willmsgreq() {
    return Body{}.as(Msg::willmsgreq);
}
inline Octets willmsg(std::string_view message) {
    return Body{}.text(message).as(Msg::willmsg);
}
inline Octets register_topic(unsigned topic_id, unsigned msg_id, std::string_view name) {
    return Body{}.u16(topic_id).u16(msg_id).text(name).as(Msg::register_);
}
inline Octets regack(unsigned topic_id, unsigned msg_id, Code code) {
    return Body{}.u16(topic_id).u16(msg_id).u8(code).as(Msg::regack);
}
inline Octets publish(Flags flags, unsigned topic, unsigned msg_id, std::string_view data) {
    return Body{}.u8(flags).u16(topic).u16(msg_id).text(data).as(Msg::publish);
}
inline Octets puback(unsigned topic, unsigned msg_id, Code code = accepted) {
    return Body{}.u16(topic).u16(msg_id).u8(code).as(Msg::puback);
}
inline Octets pubrec(unsigned msg_id) {
    return Body{}.u16(msg_id).as(Msg::pubrec);
}
inline Octets pubrel(unsigned msg_id) {
    return Body{}.u16(msg_id).as(Msg::pubrel);
}
inline Octets pubcomp(unsigned msg_id) {
    return Body{}.u16(msg_id).as(Msg::pubcomp);
}
inline Octets subscribe(Flags flags, unsigned msg_id, std::string_view name) {
    return Body{}.u8(flags).u16(msg_id).text(name).as(Msg::subscribe);
}
inline Octets subscribe_id(Flags flags, unsigned msg_id, unsigned topic_id) {
    return Body{}.u8(flags | predefined).u16(msg_id).u16(topic_id).as(Msg::subscribe);
}
inline Octets suback(Flags flags, unsigned topic_id, unsigned msg_id, Code code = accepted) {
    return Body{}.u8(flags).u16(topic_id).u16(msg_id).u8(code).as(Msg::suback);
}
inline Octets unsubscribe(Flags flags, unsigned msg_id, std::string_view name) {
    return Body{}.u8(flags).u16(msg_id).text(name).as(Msg::unsubscribe);
}
inline Octets unsuback(unsigned msg_id) {
    return Body{}.u16(msg_id).as(Msg::unsuback);
}
inline Octets pingreq(std::string_view client_id = {}) {
    return Body{}.text(client_id).as(Msg::pingreq);
}
inline Octets pingresp() {
    return Body{}.as(Msg::pingresp);
}
inline Octets disconnect() {
    return Body{}.as(Msg::disconnect);
}
inline Octets disconnect_for(unsigned duration_s) {
    return Body{}.u16(duration_s).as(Msg::disconnect);
}
inline Octets willtopicupd(std::string_view topic, Flags flags = no_flags) {
    return Body{}.u8(flags).text(topic).as(Msg::willtopicupd);
}
inline Octets empty_willtopicupd() {
    return Body{}.as(Msg::willtopicupd);
}
inline Octets willtopicresp(Code code) {
    return Body{}.u8(code).as(Msg::willtopicresp);
}
inline Octets willmsgupd(std::string_view message) {
    return Body{}.text(message).as(Msg::willmsgupd);
}
inline Octets willmsgresp(Code code) {
    return Body{}.u8(code).as(Msg::willmsgresp);
}
/// Section 5.5: the header's length does not count the message behind it.
inline Octets encapsulated(std::string_view node_id, const Octets& message, unsigned ctrl = 0) {
    Octets frame = Body{}.u8(ctrl).text(node_id).as(Msg::encapsulated);
    frame.insert(frame.end(), message.begin(), message.end());
    return frame;
}

/// "CONNACK 03 05 00": for the words of a failed expectation.
std::string describe(const Octets& datagram);

}  // namespace romano::conformance
