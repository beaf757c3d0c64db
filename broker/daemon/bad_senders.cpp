#include "broker/daemon/bad_senders.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <string>

#include "broker/net/endpoint_text.h"
#include "romano/mqttsn/codec.h"

namespace romano::daemon {
namespace {

std::string beginning_of(Bytes datagram) {
    constexpr std::size_t shown = 16;
    constexpr std::string_view digits = "0123456789abcdef";
    std::string text;
    for (const std::uint8_t octet : datagram.first(std::min(shown, datagram.size()))) {
        text += {' ', digits[octet >> 4U], digits[octet & 0xFU]};
    }
    return text + (datagram.size() > shown ? " ..." : "");
}

}  // namespace

void BadSenders::note(const Endpoint& from, Bytes datagram) {
    if (mqttsn::decode(datagram)) return;  // it was another one, which had waited
    if (named_.size() >= most || !named_.insert(from).second) return;
    spdlog::warn("{} sent {} octets that are no MQTT-SN:{} (said once, then counted)",
                 net::to_text(from), datagram.size(), beginning_of(datagram));
    if (named_.size() == most) {
        spdlog::warn("{} senders of such datagrams were named; further ones are only counted",
                     most);
    }
}

}  // namespace romano::daemon
