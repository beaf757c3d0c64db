#include "broker/daemon/settings.h"

#include <net/if.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <limits>
#include <span>
#include <string_view>

#include "broker/daemon/address_setting.h"
#include "broker/daemon/default_name.h"
#include "broker/daemon/http_settings.h"
#include "broker/daemon/refusal.h"
#include "broker/daemon/uplink_settings.h"
#include "broker/net/discovery_group.h"
#include "broker/net/endpoint_text.h"
#include "broker/net/socket_address.h"
#include "election/elector.h"
#include "election/failure_detector.h"
#include "election/profile.h"
#include "romano/mqttsn/topic.h"

namespace romano::daemon {
namespace {

using std::chrono::milliseconds;

constexpr std::uint32_t highest_domain = 230;  // DDSI's port numbers end there

std::optional<std::uint64_t> parse_number(std::string_view text) {
    std::uint64_t number = 0;
    const char* end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, number);
    if (error != std::errc{} || stop != end) return std::nullopt;
    return number;
}

template <typename Number>
Number number_in(std::string_view option, std::string_view text, Number low, Number high) {
    const auto number = parse_number(text);
    if (!number || *number < low || *number > high) {
        refuse_option(
            option, text,
            "must be a whole number from " + std::to_string(low) + " to " + std::to_string(high));
    }
    return static_cast<Number>(*number);
}

template <typename Names>
std::string one_of(std::string_view option, const std::string& text, const Names& known) {
    if (std::ranges::find(known, text) != std::ranges::end(known)) return text;
    std::string list;
    for (const std::string_view name : known) {
        list += (list.empty() ? "" : ", ") + std::string(name);
    }
    refuse_option(option, text, "is not known; choose one of: " + list);
}

Endpoint plain(Endpoint endpoint) {
    endpoint.packets = Endpoint::Packets::plain;
    return endpoint;
}

void refuse_plain(const Endpoint& endpoint) {
    const std::string address = net::to_text(endpoint);
    refuse_option("listen", address,
                  "is plain, and whoever reaches it steers robots and reads everything; give "
                  "--allow-plain if that may be, or protected://" +
                      address + " with --keys, or an address that this machine alone reaches, " +
                      "such as 127.0.0.1:1883");
}

std::vector<Endpoint> check_listen(const std::vector<std::string>& texts, bool allow_plain) {
    if (texts.empty()) {
        return {*net::parse_endpoint(allow_plain ? "0.0.0.0:1883" : "127.0.0.1:1883")};
    }
    std::vector<Endpoint> out;
    for (const std::string& text : texts) {
        const auto parsed = net::parse_service_address(text);
        const Endpoint endpoint = parsed ? *parsed : address_and_port("listen", text);
        if (net::is_multicast(endpoint)) {
            refuse_option("listen", text,
                          "is a multicast group; clients need an address of this machine");
        }
        if (net::is_link_local(endpoint) && endpoint.scope == 0) {
            refuse_option("listen", text,
                          "is link-local, the same on every network; name the interface, for "
                          "example [fe80::1%eth0]:1883");
        }
        const auto is_same = [&](const Endpoint& other) { return plain(other) == plain(endpoint); };
        if (endpoint.port != 0 && std::ranges::any_of(out, is_same)) {
            refuse_option("listen", text, "is given twice; once is enough");
        }
        if (endpoint.packets == Endpoint::Packets::plain && !allow_plain &&
            !net::is_loopback(endpoint)) {
            refuse_plain(endpoint);
        }
        out.push_back(endpoint);
    }
    return out;
}

std::optional<std::string> check_keys(const SettingTexts& texts,
                                      const std::vector<Endpoint>& listen) {
    const auto keyed = std::ranges::find_if(
        listen, [](const Endpoint& each) { return each.packets != Endpoint::Packets::plain; });
    if (keyed != listen.end() && !texts.keys) {
        refuse_option("listen", net::to_text(*keyed),
                      "needs the keys of its clients; give --keys DIR, which `romano keys new` "
                      "makes");
    }
    if (texts.keys && keyed == listen.end() && !texts.domain) {
        refuse_option("keys", *texts.keys,
                      "is for clients with keys; give --listen protected://ADDR:PORT or "
                      "dtls://ADDR:PORT too");
    }
    return texts.keys;
}

/// T_ADV, which ADVERTISE carries in 16 bits (MQTT-SN 1.2 section 5.4.1).
std::chrono::seconds check_advertise_period(const SettingTexts& texts, bool advertises) {
    constexpr std::chrono::minutes usual{15};  // section 7.2
    const auto& text = texts.advertise_period;
    const auto given =
        text ? std::chrono::seconds{number_in<std::uint16_t>("advertise-period", *text, 1, 65'535)}
             : usual;
    if (text && !advertises) {
        refuse_option("advertise-period", *text, "is for discovery; give --discovery-group too");
    }
    return advertises ? given : std::chrono::seconds{0};
}

std::vector<Endpoint> check_groups(const std::vector<std::string>& texts,
                                   const std::vector<Endpoint>& listen) {
    const auto has_family = [&](Endpoint::Family family) {
        return std::ranges::any_of(listen, [&](const auto& at) { return at.family == family; });
    };
    std::vector<Endpoint> out;
    for (const std::string& text : texts) {
        if (text == "default") {
            std::ranges::copy_if(net::usual_discovery_groups(), std::back_inserter(out),
                                 [&](const auto& group) { return has_family(group.family); });
            continue;
        }
        const Endpoint group = address_and_port("discovery-group", text);
        if (!net::is_multicast(group) || group.port == 0) {
            refuse_option("discovery-group", text,
                          "is no multicast group and port; for example 225.1.1.1:1883");
        }
        if (!has_family(group.family)) {
            refuse_option("discovery-group", text,
                          "needs a --listen address of the same family (IPv4 or IPv6)");
        }
        out.push_back(group);
    }
    return out;
}

std::optional<Endpoint> check_cell_group(const std::optional<std::string>& text,
                                         const std::vector<Endpoint>& listen,
                                         const std::vector<Endpoint>& discovery_groups) {
    if (!text) return {};
    const Endpoint group = address_and_port("cell-group", *text);
    if (!net::is_multicast(group) || group.port == 0) {
        refuse_option("cell-group", *text,
                      "is no multicast group and port; for example 239.18.83.1:1884");
    }
    if (net::is_link_group(group) && group.scope == 0) {
        refuse_option("cell-group", *text,
                      "is a group of each link; name the interface, for example "
                      "[ff02::1883%eth0]:1884");
    }
    if (std::ranges::find(discovery_groups, group) != discovery_groups.end()) {
        refuse_option("cell-group", *text,
                      "is the --discovery-group, where clients listen that do not expect "
                      "messages; take another port");
    }
    const bool has_listener = std::ranges::any_of(listen, [&](const Endpoint& at) {
        return at.family == group.family && at.packets == Endpoint::Packets::plain;
    });
    if (!has_listener) {
        refuse_option("cell-group", *text,
                      "needs a plain --listen address of the same family (IPv4 or IPv6): clients "
                      "with keys are never sent anything to a group");
    }
    return group;
}

void check_broker_name(std::string_view option, const std::string& text) {
    const bool printable =
        std::ranges::all_of(text, [](char c) { return static_cast<unsigned char>(c) > ' '; });
    if (!printable || text.size() > longest_name || !mqttsn::is_valid_topic_name(text) ||
        text.find_first_of("/,") != std::string::npos) {
        refuse_option(option, text, "must be 1 to 64 octets without spaces, ',', '/', '+' and '#'");
    }
}

std::string check_name(const std::optional<std::string>& text, const Endpoint& first) {
    if (!text) return default_name(host_name(), first, hardware_address());
    check_broker_name("name", *text);
    return *text;
}

std::map<mqttsn::TopicId, std::string> check_predefined(const std::vector<std::string>& texts) {
    std::map<mqttsn::TopicId, std::string> out;
    for (const std::string& text : texts) {
        const auto equals = text.find('=');
        if (equals == std::string::npos) {
            refuse_option("predefined", text, "must be ID=TOPIC, for example 1=robots/pose");
        }
        const auto id = parse_number(std::string_view(text).substr(0, equals));
        if (!id || *id == 0 || *id >= 0xFFFF) {
            refuse_option("predefined", text, "must begin with a topic id from 1 to 65534");
        }
        const std::string topic = text.substr(equals + 1);
        if (!mqttsn::is_valid_topic_name(topic)) {
            refuse_option("predefined", text,
                          "must end with a topic name: UTF-8, not empty, without '+' and '#'");
        }
        if (!out.emplace(static_cast<mqttsn::TopicId>(*id), topic).second) {
            refuse_option("predefined", text, "gives this topic id a second topic; an id has one");
        }
    }
    return out;
}

broker::Limits check_limits(const std::map<std::string, std::string>& texts) {
    broker::Limits out;
    for (const LimitSetting& setting : limit_settings()) {
        out.*setting.limit =
            number_in(setting.key, texts.at(setting.key), setting.low, setting.high);
    }
    return out;
}

std::optional<StoreSettings> check_store(const SettingTexts& texts) {
    constexpr std::uint64_t usual_limit = 1024;
    constexpr std::uint64_t highest_limit = 1U << 20U;
    const auto mebioctets =
        texts.store_limit_mb
            ? number_in<std::uint64_t>("store-limit-mb", *texts.store_limit_mb, 1, highest_limit)
            : usual_limit;
    if (!texts.store) {
        if (texts.store_limit_mb) {
            refuse_option("store-limit-mb", *texts.store_limit_mb,
                          "is for a store; give --store too");
        }
        if (texts.store_sync) throw Refusal("--store-sync is for a store; give --store too");
        return std::nullopt;
    }
    if (texts.store->empty()) refuse_option("store", *texts.store, "must be the path of a file");
    if (texts.domain) {
        refuse_option("store", *texts.store,
                      "is for a broker alone: in a cluster the peers keep the sessions; leave out "
                      "--store or --domain");
    }
    return StoreSettings{*texts.store, mebioctets << 20U, texts.store_sync};
}

std::string check_interface(const std::optional<std::string>& text) {
    if (!text) return {};
    if (!text->empty() && if_nametoindex(text->c_str()) != 0) return *text;
    std::string list;
    if (auto* const interfaces = if_nameindex()) {
        for (auto* at = interfaces; at->if_index != 0; ++at) {
            list += (list.empty() ? "" : ", ") + std::string(at->if_name);
        }
        if_freenameindex(interfaces);
    }
    refuse_option("interface", *text,
                  "is no network interface of this machine; there are: " + list);
}

std::optional<std::uint32_t> check_acks(const std::string& text) {
    if (text == "all") return std::nullopt;
    const auto number = parse_number(text);
    if (!number || *number >= std::numeric_limits<std::uint32_t>::max()) {
        refuse_option("acks", text, "must be a number of peers, or all");
    }
    return static_cast<std::uint32_t>(*number);
}

election::Profile check_profile(const SettingTexts& texts) {
    using election::profiles;
    std::array<std::string_view, profiles.size()> names{};
    std::ranges::transform(profiles, names.begin(), &election::Profile::name);
    const std::string name = one_of("profile", texts.profile, names);
    election::Profile out = *std::ranges::find(profiles, name, &election::Profile::name);
    const auto time = [](std::string_view option, const auto& text, milliseconds& value,
                         std::uint32_t low, std::uint32_t high) {
        if (text) value = milliseconds(number_in<std::uint32_t>(option, *text, low, high));
    };
    time("beacon-ms", texts.beacon_ms, out.beacon_every, 1, 10'000);
    const auto least = static_cast<std::uint32_t>(2 * out.beacon_every.count());
    time("detection-timeout-ms", texts.detection_timeout_ms, out.detection_timeout, least, 600'000);
    if (out.detection_timeout.count() < least) {
        refuse_option("beacon-ms", *texts.beacon_ms,
                      "is too long for a detection timeout of " +
                          std::to_string(out.detection_timeout.count()) +
                          " ms; give --detection-timeout-ms at least twice as much");
    }
    if (texts.phi_threshold) {
        out.phi_threshold = number_in<std::uint32_t>("phi-threshold", *texts.phi_threshold, 1, 300);
    }
    time("retry-ms", texts.retry_ms, out.t_retry, 10, 600'000);
    if (texts.retries) out.n_retry = number_in<std::uint16_t>("retries", *texts.retries, 0, 10'000);
    return out;
}

std::vector<std::string> check_voters(const SettingTexts& texts) {
    if (texts.elector != "raft") {
        if (!texts.voters.empty()) {
            refuse_option("voters", texts.voters.front(),
                          "is for the elector raft; give --elector raft");
        }
        return {};
    }
    std::vector<std::string> voters;
    for (const std::string& names : texts.voters) {
        for (std::size_t from = 0; from <= names.size();) {
            const std::size_t end = std::min(names.find(',', from), names.size());
            voters.push_back(names.substr(from, end - from));
            check_broker_name("voters", voters.back());
            from = end + 1;
        }
    }
    if (voters.empty()) {
        refuse_option(
            "elector", texts.elector,
            "needs --voters: the names of the brokers that vote, for example --voters r1,r2,r3");
    }
    for (const std::string& voter : voters) {
        if (std::ranges::count(voters, voter) > 1) {
            refuse_option("voters", voter, "is given twice; each broker has one vote");
        }
    }
    return voters;
}

/// What a broker alone would silently not do. A default that is written out, as in an uncommented
/// --default-config, asks for nothing; the times are a profile's, which sets Tretry too.
void check_alone(const SettingTexts& texts) {
    const SettingTexts defaults;
    const auto is_for_a_cluster = [](std::string_view option, const std::string& value) {
        refuse_option(option, value, "is for the brokers of a cluster; give --domain too");
    };
    if (texts.interface) is_for_a_cluster("interface", *texts.interface);
    if (texts.rank != defaults.rank) is_for_a_cluster("rank", texts.rank);
    if (texts.acks != defaults.acks) is_for_a_cluster("acks", texts.acks);
    if (texts.elector != defaults.elector) is_for_a_cluster("elector", texts.elector);
    if (texts.detector != defaults.detector) is_for_a_cluster("detector", texts.detector);
}

std::optional<ClusterSettings> check_cluster(const SettingTexts& texts,
                                             const election::Profile& profile) {
    ClusterSettings out;
    // Also without --domain: a setting that is wrong is wrong.
    out.rank =
        number_in<std::uint32_t>("rank", texts.rank, 0, std::numeric_limits<std::uint32_t>::max());
    if (texts.condition_file && !texts.domain) {
        refuse_option("condition-file", *texts.condition_file,
                      "is for the brokers of a cluster; give --domain too");
    }
    out.condition_file = texts.condition_file;
    out.acks = check_acks(texts.acks);
    out.elector = one_of("elector", texts.elector, election::elector_names());
    out.detector = one_of("detector", texts.detector, election::detector_names());
    out.voters = check_voters(texts);
    out.profile = profile.name;
    out.beacon_every = profile.beacon_every;
    out.detection_timeout = profile.detection_timeout;
    out.phi_threshold = profile.phi_threshold;
    if (texts.plain_peers && !(texts.domain && texts.keys)) {
        throw Refusal(
            "--plain-peers is for the brokers of a cluster that have --keys; give "
            "--domain and --keys too");
    }
    if (!texts.domain) {
        check_alone(texts);
        return std::nullopt;
    }
    out.is_protected = texts.keys && !texts.plain_peers;
    out.interface = check_interface(texts.interface);
    out.domain = number_in<std::uint32_t>("domain", *texts.domain, 0, highest_domain);
    return out;
}

std::optional<Ros2Settings> check_ros2(const SettingTexts& texts, const Settings& checked) {
    static constexpr std::array<std::string_view, 3> releases = {"humble", "iron", "jazzy"};
    const std::string release = one_of("ros2-release", texts.ros2_release, releases);
    if (!texts.ros2_domain) {
        if (texts.ros2_rules || texts.ros2_interface) {
            throw Refusal(std::string("--") + (texts.ros2_rules ? "ros2-rules" : "ros2-interface") +
                          " needs --ros2-domain: the ROS_DOMAIN_ID of the nodes");
        }
        return std::nullopt;
    }
    const auto& text = *texts.ros2_domain;
    const auto domain = number_in<std::uint32_t>("ros2-domain", text, 0, highest_domain);
    if (!checked.cluster) {
        refuse_option("ros2-domain", text,
                      "is bridged by the broker that leads a cluster; give --domain too (a cluster "
                      "of one leads itself)");
    }
    if (domain == checked.cluster->domain) {
        refuse_option("ros2-domain", text, "is the brokers' own --domain; choose another for them");
    }
    if (checked.uplink) {
        refuse_option("ros2-domain", text, "and --uplink exclude each other; choose one");
    }
    if (!texts.ros2_rules) {
        throw Refusal("--ros2-domain needs --ros2-rules: a file that says what is bridged");
    }
    return Ros2Settings{.domain = domain,
                        .rules_file = *texts.ros2_rules,
                        .interface = texts.ros2_interface.value_or(checked.cluster->interface),
                        .release = release};
}

}  // namespace

Settings check(const SettingTexts& texts) {
    static constexpr std::array<std::string_view, 6> levels = {"trace", "debug", "info",
                                                               "warn",  "error", "off"};
    Settings out;
    out.listen = check_listen(texts.listen, texts.allow_plain);
    out.allow_plain = texts.allow_plain;
    out.keys = check_keys(texts, out.listen);
    out.rights = texts.rights;
    // Brokers of many machines may serve the same default address.
    const Endpoint all = *net::parse_endpoint("0.0.0.0:1883");
    out.name = check_name(texts.name, texts.listen.empty() ? all : plain(out.listen.front()));
    out.discovery_groups = check_groups(texts.discovery_group, out.listen);
    out.cell_group = check_cell_group(texts.cell_group, out.listen, out.discovery_groups);
    out.gateway_id = number_in<std::uint8_t>("gateway-id", texts.gateway_id, 1, 255);
    out.advertise_period = check_advertise_period(texts, !out.discovery_groups.empty());
    out.predefined_topics = check_predefined(texts.predefined);
    out.romano = !texts.no_romano;
    out.metrics = check_metrics(texts);
    out.web = check_web(texts, out.listen);
    out.limits = check_limits(texts.limits);
    const election::Profile profile = check_profile(texts);
    out.t_retry = profile.t_retry;
    out.n_retry = profile.n_retry;
    out.realtime = texts.realtime;
    out.store = check_store(texts);
    out.cluster = check_cluster(texts, profile);
    out.uplink = check_uplink(texts);
    out.ros2 = check_ros2(texts, out);
    out.log_level = one_of("log-level", texts.log_level, levels);
    return out;
}

}  // namespace romano::daemon
