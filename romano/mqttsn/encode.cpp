#include "romano/mqttsn/encode.h"

#include <type_traits>
#include <variant>

#include "romano/mqttsn/codec.h"

namespace romano::mqttsn {
namespace {

template <typename M>
std::size_t encode_framed(const M& message, MutableBytes out) {
    const std::size_t body = body_size(message);
    std::uint8_t* at = begin_frame(M::type, body, out);
    if (at == nullptr) return 0;
    put(message, Fields{at});
    return framed_size(body);
}

}  // namespace

std::size_t encode(const Advertise& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Searchgw& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Gwinfo& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Connect& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Connack& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Willtopicreq& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Willtopic& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Willmsgreq& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Willmsg& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Register& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Regack& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Publish& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Puback& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Pubcomp& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Pubrec& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Pubrel& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Subscribe& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Suback& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Unsubscribe& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Unsuback& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Pingreq& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Pingresp& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Disconnect& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Willtopicupd& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Willtopicresp& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Willmsgupd& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Willmsgresp& m, MutableBytes out) {
    return encode_framed(m, out);
}

/// Section 5.5: the length octet counts the forwarder's header only.
std::size_t encode(const Encapsulated& m, MutableBytes out) {
    const std::size_t header = 3 + m.wireless_node_id.size();
    if (header > 255 || header + m.message.size() > out.size()) return 0;
    Fields{out.data()}
        .u8(static_cast<std::uint8_t>(header))
        .u8(static_cast<std::uint8_t>(MsgType::encapsulated))
        .u8(m.radius & 3U)
        .octets(m.wireless_node_id)
        .octets(m.message);
    return header + m.message.size();
}

std::size_t encode(const Message& message, MutableBytes out) {
    return std::visit([out](const auto& m) { return encode(m, out); }, message);
}

std::size_t encoded_size(const Publish& message) {
    return framed_size(body_size(message));
}

std::size_t encoded_size(const Message& message) {
    return std::visit(
        [](const auto& m) -> std::size_t {
            if constexpr (std::is_same_v<decltype(m), const Encapsulated&>) {
                return 3 + m.wireless_node_id.size() + m.message.size();
            } else {
                return framed_size(body_size(m));
            }
        },
        message);
}

}  // namespace romano::mqttsn
