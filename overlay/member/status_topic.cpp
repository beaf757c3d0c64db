#include "overlay/member/status_topic.h"

#include <cstdint>
#include <string_view>

namespace romano::overlay {
namespace {

constexpr std::string_view hex = "0123456789abcdef";

std::string quoted(std::string_view text) {
    std::string out = "\"";
    for (const char c : text) {
        const auto octet = static_cast<unsigned char>(c);
        if (c == '"' || c == '\\') {
            out += '\\';
            out += c;
        } else if (octet < 0x20) {
            out += "\\u00";
            out += hex[octet >> 4U];
            out += hex[octet & 0xFU];
        } else {
            out += c;
        }
    }
    return out + '"';
}

template <typename Items, typename ToText>
std::string list_of(const Items& items, ToText&& text_of) {
    std::string out = "[";
    for (const auto& item : items) {
        if (out.size() > 1) out += ',';
        out += quoted(text_of(item));
    }
    return out + ']';
}

std::string field(std::string_view name, const std::string& value) {
    return quoted(name) + ':' + value;
}

std::string number(std::uint64_t value) {
    return std::to_string(value);
}
std::string truth(bool value) {
    return value ? "true" : "false";
}

std::string group_of(const Endpoint& endpoint, std::size_t group) {
    const auto value =
        static_cast<unsigned>((endpoint.address[2 * group] << 8) | endpoint.address[2 * group + 1]);
    std::string digits;
    for (unsigned shift = 16; shift > 0;) {
        shift -= 4;
        const unsigned digit = (value >> shift) & 0xFU;
        if (digit != 0 || !digits.empty() || shift == 0) digits += hex[digit];
    }
    return digits;
}

std::string ipv6_text(const Endpoint& endpoint) {
    // RFC 5952: the longest run of two or more zero groups becomes "::".
    std::size_t run_at = 8;
    std::size_t run_length = 1;
    for (std::size_t at = 0; at < 8; ++at) {
        std::size_t length = 0;
        while (at + length < 8 && endpoint.address[2 * (at + length)] == 0 &&
               endpoint.address[2 * (at + length) + 1] == 0) {
            ++length;
        }
        if (length > run_length) {
            run_at = at;
            run_length = length;
        }
    }
    std::string text;
    for (std::size_t group = 0; group < 8; ++group) {
        if (group == run_at) {
            text += "::";
            group += run_length - 1;
            continue;
        }
        if (!text.empty() && text.back() != ':') text += ':';
        text += group_of(endpoint, group);
    }
    if (endpoint.scope != 0) text += '%' + number(endpoint.scope);
    return text;
}

/// `"predefined":{"r1":"1=pose","r2":"1=stop"}`: this broker's value, and the teller's.
std::string differences_of(const BrokerStatus& status) {
    std::string out = "{";
    for (const cluster::Difference& difference : status.differences) {
        if (out.size() > 1) out += ',';
        out += field(difference.setting,
                     '{' + field(status.beacon.name, quoted(difference.theirs)) + ',' +
                         field(status.teller_name, quoted(difference.ours)) + '}');
    }
    return out + '}';
}

}  // namespace

std::string to_text(const Endpoint& endpoint) {
    if (endpoint.packets != Endpoint::Packets::plain) {
        Endpoint plain = endpoint;
        plain.packets = Endpoint::Packets::plain;
        return (endpoint.packets == Endpoint::Packets::dtls ? "dtls://" : "protected://") +
               to_text(plain);
    }
    const std::string port = ':' + number(endpoint.port);
    if (endpoint.family == Endpoint::Family::none) return "none";
    if (endpoint.family == Endpoint::Family::ipv6) return '[' + ipv6_text(endpoint) + ']' + port;
    std::string text;
    for (std::size_t i = 0; i < 4; ++i) {
        if (i > 0) text += '.';
        text += number(endpoint.address[i]);
    }
    return text + port;
}

std::string status_topic(const std::string& name) {
    return "$SYS/brokers/" + name;
}

std::string to_json(const BrokerStatus& status) {
    const cluster::Beacon& beacon = status.beacon;
    const std::string view =
        '{' + field("term", number(status.view.number.term)) + ',' +
        field("leader", quoted(status.leader_name)) + ',' +
        field("count", number(status.view.number.count)) + ',' +
        field("members", list_of(status.member_names, [](const auto& name) { return name; })) + '}';
    return '{' + field("name", quoted(beacon.name)) + ',' + field("alive", truth(status.alive)) +
           ',' + field("leader", truth(status.leads)) + ',' +
           field("rank", number(beacon.claim.rank.capability)) + ',' +
           field("condition", number(beacon.claim.rank.condition)) + ',' +
           field("sessions", number(beacon.sessions)) + ',' +
           field("connected", number(beacon.connected)) + ',' +
           field("addresses", list_of(beacon.serving, to_text)) + ',' +
           field("cannot_take", number(beacon.cannot_take)) + ',' + field("view", view) + ',' +
           field("incarnation", number(beacon.log.incarnation)) + ',' +
           field("transport_octets_sent", number(beacon.usage.transport_octets_sent)) + ',' +
           field("transport_octets_received", number(beacon.usage.transport_octets_received)) +
           ',' + field("longest_turn_us", number(beacon.usage.longest_turn_us)) + ',' +
           field("cpu_percent", number(beacon.usage.cpu_percent)) +
           (status.does_not_hear.empty()
                ? std::string{}
                : ',' + field("does_not_hear", list_of(status.does_not_hear,
                                                       [](const auto& name) { return name; }))) +
           (status.rights.empty() ? std::string{} : ',' + field("rights", quoted(status.rights))) +
           (status.differences.empty() ? std::string{}
                                       : ',' + field("disagrees", differences_of(status))) +
           '}';
}

}  // namespace romano::overlay
