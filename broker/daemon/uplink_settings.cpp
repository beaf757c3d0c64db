#include "broker/daemon/uplink_settings.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <fstream>
#include <string>
#include <string_view>

#include "broker/daemon/refusal.h"

namespace romano::daemon {
namespace {

constexpr std::size_t longest_network = 32;
constexpr std::uint16_t plain_port = 1883;
constexpr std::uint16_t tls_port = 8883;

/// HOST, HOST:PORT, [ADDRESS], [ADDRESS]:PORT.
bool read_place(std::string_view text, uplink::MqttSettings& out) {
    if (text.starts_with('[')) {
        const auto end = text.find(']');
        if (end == std::string_view::npos) return false;
        out.host = text.substr(1, end - 1);
        text.remove_prefix(end + 1);
    } else {
        const auto end = std::min(text.find(':'), text.size());
        out.host = text.substr(0, end);
        text.remove_prefix(end);
    }
    if (out.host.empty()) return false;
    if (text.empty()) return true;
    if (text.front() != ':') return false;
    text.remove_prefix(1);
    const auto read = std::from_chars(text.data(), text.data() + text.size(), out.port);
    return read.ec == std::errc{} && read.ptr == text.data() + text.size() && out.port != 0;
}

uplink::MqttSettings check_place(const std::string& text) {
    uplink::MqttSettings out;
    const std::string_view all = text;
    std::string_view place;
    if (all.starts_with("mqtts://")) {
        out.tls = true;
        place = all.substr(8);
    } else if (all.starts_with("mqtt://")) {
        place = all.substr(7);
    }
    out.port = out.tls ? tls_port : plain_port;
    if (!read_place(place, out)) {
        refuse_option(
            "uplink", text,
            "is no MQTT broker; write mqtt://HOST:PORT or mqtts://HOST:PORT, an IPv6 address in "
            "brackets");
    }
    return out;
}

std::string check_network(const std::optional<std::string>& text) {
    if (!text) {
        throw Refusal(
            "--uplink needs --uplink-network: a name that this network's brokers share and no "
            "other "
            "network has at the MQTT broker");
    }
    const auto fits = [](char letter) {
        return std::isalnum(static_cast<unsigned char>(letter)) != 0 || letter == '-' ||
               letter == '_' || letter == '.';
    };
    if (text->empty() || text->size() > longest_network || !std::ranges::all_of(*text, fits)) {
        refuse_option("uplink-network", *text,
                      "must be 1 to 32 letters, digits, dots, hyphens and underscores");
    }
    return *text;
}

std::vector<uplink::TopicRule> check_rules(const std::vector<std::string>& texts) {
    if (texts.empty()) {
        throw Refusal(
            "--uplink needs --uplink-topic: what is exchanged, for example 'fleet/# both'");
    }
    std::vector<uplink::TopicRule> rules;
    for (const std::string& text : texts) {
        auto rule = uplink::parse_rule(text);
        if (!rule) refuse_option("uplink-topic", text, rule.error());
        rules.push_back(std::move(*rule));
    }
    return rules;
}

std::string password_in(const std::string& path) {
    std::ifstream file(path);
    std::string line;
    if (!std::getline(file, line) || line.empty()) {
        refuse_option("uplink-password-file", path,
                      "cannot be read; its first line is the password");
    }
    return line;
}

void check_readable(const std::string& path) {
    std::ifstream file(path);
    if (file.peek() == std::ifstream::traits_type::eof()) {
        refuse_option("uplink-ca", path, "cannot be read; give a file of PEM certificates");
    }
}

void refuse_without_uplink(const SettingTexts& texts) {
    const auto refuse_if = [](const char* option, bool given) {
        if (given) throw Refusal("--" + std::string(option) + " needs --uplink: where to");
    };
    refuse_if("uplink-network", texts.uplink_network.has_value());
    refuse_if("uplink-topic", !texts.uplink_topic.empty());
    refuse_if("uplink-ca", texts.uplink_ca.has_value());
    refuse_if("uplink-username", texts.uplink_username.has_value());
    refuse_if("uplink-password-file", texts.uplink_password_file.has_value());
}

}  // namespace

std::optional<UplinkSettings> check_uplink(const SettingTexts& texts) {
    if (!texts.uplink) {
        refuse_without_uplink(texts);
        return std::nullopt;
    }
    UplinkSettings out{.mqtt = check_place(*texts.uplink), .options = {}};
    if (!texts.domain) {
        refuse_option(
            "uplink", *texts.uplink,
            "is held by the broker that leads a cluster; give --domain too (a cluster of one "
            "leads itself)");
    }
    out.options = {.network = check_network(texts.uplink_network),
                   .rules = check_rules(texts.uplink_topic)};
    if (texts.uplink_ca) {
        if (!out.mqtt.tls) refuse_option("uplink-ca", *texts.uplink_ca, "is for mqtts://");
        check_readable(*texts.uplink_ca);
        out.mqtt.ca_file = *texts.uplink_ca;
    }
    if (texts.uplink_password_file && !texts.uplink_username) {
        refuse_option("uplink-password-file", *texts.uplink_password_file,
                      "needs --uplink-username");
    }
    out.mqtt.username = texts.uplink_username.value_or("");
    if (texts.uplink_password_file) out.mqtt.password = password_in(*texts.uplink_password_file);
    out.mqtt.client_id = "romano-" + out.options.network;
    out.mqtt.filters = uplink::TopicRules(out.options.rules).remote_filters();
    return out;
}

}  // namespace romano::daemon
