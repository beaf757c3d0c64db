// The command line and the configuration file, still as text: one field an option. Every option
// is also a key of the file; what the command line says goes before the file.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "broker/daemon/limit_settings.h"

namespace romano::daemon {

struct SettingTexts {
    std::vector<std::string> listen = {};
    bool allow_plain = false;
    std::optional<std::string> keys = {};
    std::optional<std::string> rights = {};
    std::optional<std::string> name = {};
    std::optional<std::string> domain = {};
    std::optional<std::string> interface = {};
    bool plain_peers = false;
    std::string rank = "0";
    std::optional<std::string> condition_file = {};
    std::string acks = "1";
    std::string elector = "component";
    std::vector<std::string> voters = {};
    std::string detector = "link";
    std::string profile = "lan";
    // Those of the profile, unless given.
    std::optional<std::string> beacon_ms = {};
    std::optional<std::string> detection_timeout_ms = {};
    std::optional<std::string> phi_threshold = {};
    std::optional<std::string> retry_ms = {};
    std::optional<std::string> retries = {};
    bool realtime = false;
    std::string gateway_id = "1";
    std::optional<std::string> advertise_period = {};
    std::vector<std::string> predefined = {};
    std::vector<std::string> discovery_group = {};
    std::optional<std::string> cell_group = {};
    bool no_romano = false;
    std::optional<std::string> store = {};
    std::optional<std::string> store_limit_mb = {};
    bool store_sync = false;
    std::map<std::string, std::string> limits = default_limit_texts();  // by key
    std::optional<std::string> uplink = {};
    std::optional<std::string> uplink_network = {};
    std::vector<std::string> uplink_topic = {};
    std::optional<std::string> uplink_ca = {};
    std::optional<std::string> uplink_username = {};
    std::optional<std::string> uplink_password_file = {};
    std::optional<std::string> ros2_domain = {};
    std::optional<std::string> ros2_rules = {};
    std::optional<std::string> ros2_interface = {};
    std::string ros2_release = "jazzy";
    std::optional<std::string> metrics = {};
    std::optional<std::string> metrics_token = {};
    std::optional<std::string> web = {};
    std::optional<std::string> web_key = {};
    std::optional<std::string> web_token = {};
    std::optional<std::string> http_certificate = {};
    bool let_everybody_steer = false;
    std::string log_level = "info";
};

/// What --help, --version and --default-config want printed instead.
struct Information {
    std::string text;
};

/// Throws Refusal for an unknown option or key, and for a file that cannot be read.
[[nodiscard]] std::variant<SettingTexts, Information> read_command_line(int argc,
                                                                        const char* const* argv);

}  // namespace romano::daemon
