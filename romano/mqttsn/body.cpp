#include "romano/mqttsn/body.h"

#include <cstring>
#include <iterator>

#include "romano/mqttsn/frame.h"

namespace romano::mqttsn {
namespace {

// The fields of a body, in their order.
enum : unsigned {
    flags = 0x01,
    protocol = 0x02,  // protocol_id
    topic = 0x04,
    msg = 0x08,
    code = 0x10,
    rest = 0x20,
    or_nothing = 0x40,  // the body may be empty instead
};

constexpr std::uint8_t fields[] = {
    flags | msg,                    // ADVERTISE
    flags,                          // SEARCHGW
    flags | rest,                   // GWINFO
    0,                              //
    flags | protocol | msg | rest,  // CONNECT
    code,                           // CONNACK
    0,                              // WILLTOPICREQ
    flags | rest | or_nothing,      // WILLTOPIC
    0,                              // WILLMSGREQ
    rest,                           // WILLMSG
    topic | msg | rest,             // REGISTER
    topic | msg | code,             // REGACK
    flags | topic | msg | rest,     // PUBLISH
    topic | msg | code,             // PUBACK
    msg,                            // PUBCOMP
    msg,                            // PUBREC
    msg,                            // PUBREL
    0,                              //
    flags | msg | rest,             // SUBSCRIBE
    flags | topic | msg | code,     // SUBACK
    flags | msg | rest,             // UNSUBSCRIBE
    msg,                            // UNSUBACK
    rest,                           // PINGREQ
    0,                              // PINGRESP
    msg | or_nothing,               // DISCONNECT
    0,                              //
    flags | rest | or_nothing,      // WILLTOPICUPD
    code,                           // WILLTOPICRESP
    rest,                           // WILLMSGUPD
    code,                           // WILLMSGRESP
};

unsigned fields_of(MsgType type) {
    const auto number = static_cast<std::size_t>(type);
    return number < std::size(fields) ? fields[number] : 0;
}

/// Of all but `rest`.
std::size_t size_of(unsigned present) {
    std::size_t size = 0;
    if ((present & flags) != 0) size += 1;
    if ((present & protocol) != 0) size += 1;
    if ((present & topic) != 0) size += 2;
    if ((present & msg) != 0) size += 2;
    if ((present & code) != 0) size += 1;
    return size;
}

}  // namespace

std::optional<Body> read_body(MsgType type, Bytes octets) {
    const unsigned present = fields_of(type);
    const std::size_t size = size_of(present);
    std::optional<Body> body;
    if (octets.empty() && (present & or_nothing) != 0) return Body{};
    if (octets.size() < size || (octets.size() > size && (present & rest) == 0)) return body;
    body.emplace();
    const std::uint8_t* at = octets.data();
    if ((present & flags) != 0) body->flags = *at++;
    if ((present & protocol) != 0) ++at;
    if ((present & topic) != 0) {
        body->topic_id = TopicId{be16({at, 2}, 0)};
        at += 2;
    }
    if ((present & msg) != 0) {
        body->msg_id = MsgId{be16({at, 2}, 0)};
        at += 2;
    }
    if ((present & code) != 0) body->code = ReturnCode{*at++};
    body->rest = octets.subspan(size);
    return body;
}

std::size_t write_message(MsgType type, const Body& body, MutableBytes out) {
    unsigned present = fields_of(type);
    const bool says_nothing = body.rest.empty() && body.msg_id == no_msg_id;
    if ((present & or_nothing) != 0 && says_nothing) present = 0;
    const std::size_t rest_size = (present & rest) != 0 ? body.rest.size() : 0;
    const std::size_t size = size_of(present) + rest_size;
    std::uint8_t* at = begin_frame(type, size, out);
    if (at == nullptr) return 0;
    if ((present & flags) != 0) *at++ = body.flags;
    if ((present & protocol) != 0) *at++ = protocol_id;
    if ((present & topic) != 0) {
        put_be16({at, 2}, 0, static_cast<std::uint16_t>(body.topic_id));
        at += 2;
    }
    if ((present & msg) != 0) {
        put_be16({at, 2}, 0, static_cast<std::uint16_t>(body.msg_id));
        at += 2;
    }
    if ((present & code) != 0) *at++ = static_cast<std::uint8_t>(body.code);
    if (rest_size != 0) std::memcpy(at, body.rest.data(), rest_size);
    return framed_size(size);
}

}  // namespace romano::mqttsn
