#include "tests/conformance/datagrams.h"

#include <array>

namespace romano::conformance {
namespace {

std::string_view name_of(std::uint8_t type) {
    static constexpr std::array<std::string_view, 0x1E> names{
        "ADVERTISE",   "SEARCHGW",   "GWINFO",       "03",
        "CONNECT",     "CONNACK",    "WILLTOPICREQ", "WILLTOPIC",
        "WILLMSGREQ",  "WILLMSG",    "REGISTER",     "REGACK",
        "PUBLISH",     "PUBACK",     "PUBCOMP",      "PUBREC",
        "PUBREL",      "11",         "SUBSCRIBE",    "SUBACK",
        "UNSUBSCRIBE", "UNSUBACK",   "PINGREQ",      "PINGRESP",
        "DISCONNECT",  "19",         "WILLTOPICUPD", "WILLTOPICRESP",
        "WILLMSGUPD",  "WILLMSGRESP"};
    if (type == static_cast<std::uint8_t>(Msg::encapsulated)) return "ENCAPSULATED";
    return type < names.size() ? names.at(type) : "reserved type";
}

}  // namespace

std::string describe(const Octets& datagram) {
    if (datagram.empty()) return "nothing";
    const std::size_t type_at = datagram[0] == 0x01 ? 3 : 1;
    std::string words{datagram.size() > type_at ? name_of(datagram[type_at]) : "no message"};
    constexpr std::string_view digits = "0123456789abcdef";
    constexpr std::size_t most = 64;
    for (std::size_t i = 0; i < datagram.size() && i < most; ++i) {
        words += {' ', digits[datagram[i] >> 4U], digits[datagram[i] & 0xFU]};
    }
    if (datagram.size() > most) words += " ... of " + std::to_string(datagram.size()) + " octets";
    return words;
}

}  // namespace romano::conformance
