// What the broker was told, checked: every field holds a possible value.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "broker/core/limits.h"
#include "broker/daemon/command_line.h"
#include "broker/https/gate_files.h"
#include "broker/uplink/mqtt/mqtt_settings.h"
#include "broker/uplink/uplink_core.h"
#include "romano/base/endpoint.h"
#include "romano/mqttsn/types.h"

namespace romano::daemon {

struct ClusterSettings {
    std::uint32_t domain = 0;
    bool is_protected = false;  // by the papers in the folder of keys
    std::string interface;      // empty: DDS chooses
    std::string elector;
    std::vector<std::string> voters;
    std::string detector;
    std::uint32_t rank = 0;
    std::optional<std::string> condition_file;
    std::optional<std::uint32_t> acks;  // empty: all peers
    std::string profile;                // whose times these are, but for those that were given
    std::chrono::milliseconds beacon_every{};
    std::chrono::milliseconds detection_timeout{};
    double phi_threshold = 0;
};

struct StoreSettings {
    std::string path;
    std::uint64_t most_octets = 0;
    bool survives_power_cut = false;
};

struct UplinkSettings {
    uplink::MqttSettings mqtt;
    uplink::UplinkOptions options;
};

struct Ros2Settings {
    std::uint32_t domain = 0;
    std::string rules_file;
    std::string interface;  // empty: DDS chooses
    std::string release;    // "humble", "iron" or "jazzy"
};

struct MetricsSettings {
    Endpoint listen;
    std::optional<https::GateFiles> gate;  // empty: plain HTTP for whoever comes
};

/// The fleet in a browser.
struct WebSettings {
    Endpoint listen;
    std::optional<std::string> key_file;   // with which it speaks to the broker; empty: plain
    std::optional<https::GateFiles> gate;  // empty: plain HTTP for whoever comes
};

struct Settings {
    std::string name;
    std::vector<Endpoint> listen;
    bool allow_plain = false;           // beyond loopback
    std::optional<std::string> keys;    // the folder of protected clients
    std::optional<std::string> rights;  // a file
    std::vector<Endpoint> discovery_groups;
    std::optional<Endpoint> cell_group;  // for clients that listen there
    std::uint8_t gateway_id = 1;
    std::chrono::seconds advertise_period{};  // 0: never
    std::map<mqttsn::TopicId, std::string> predefined_topics;
    bool romano = true;  // carries the ROMANO server
    std::optional<MetricsSettings> metrics;
    std::optional<WebSettings> web;
    broker::Limits limits;
    std::chrono::milliseconds t_retry{};
    int n_retry = 0;
    bool realtime = false;
    std::optional<StoreSettings> store;
    std::optional<ClusterSettings> cluster;
    std::optional<UplinkSettings> uplink;
    std::optional<Ros2Settings> ros2;
    std::string log_level;
    std::uint64_t least_incarnation = 0;  // others know a life of this broker before it
};

/// Throws Refusal for the first setting that is not possible.
[[nodiscard]] Settings check(const SettingTexts& texts);

}  // namespace romano::daemon
