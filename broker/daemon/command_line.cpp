#include "broker/daemon/command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <fstream>
#include <iterator>

#include "broker/daemon/config_file.h"
#include "broker/daemon/refusal.h"

namespace romano::daemon {
namespace {

constexpr const char* examples = R"(Examples:
  romano-broker
      serves programs of this machine at port 1883, alone
  romano-broker --allow-plain
      serves whoever reaches this machine: all its IPv4 addresses, without keys
  romano-broker --allow-plain --listen 192.168.1.5:1883 --listen [fd00::5]:1883 --predefined 1=robots/pose 2=robots/stop
      serves two addresses; every client knows topic id 1 and 2
  romano-broker --listen 127.0.0.1:1883 --name r1 --domain 7 --interface lo --rank 3
  romano-broker --listen 127.0.0.2:1883 --name r2 --domain 7 --interface lo
      two brokers that are one: a client may talk to either, and each takes over from the other
  romano-broker --store /var/lib/romano/store.db
      alone; after a crash or a restart its clients' sessions and messages go on
  romano-broker --allow-plain --listen 192.168.1.5:1883 --domain 7 --uplink mqtts://mqtt.example.org \
      --uplink-network site-a --uplink-topic 'fleet/# both' --uplink-topic 'pose/# out 0 "" site-a/' \
      --uplink-username site-a --uplink-password-file /etc/romano/uplink-password
      whoever leads the cluster exchanges these topics with an MQTT broker
  romano-broker --allow-plain --listen 192.168.1.5:1883 --domain 7 --ros2-domain 0 --ros2-rules turtlebots.rules
      whoever leads the cluster bridges topics to ROS 2, and robots appear there as nodes
  romano-broker --listen protected://192.168.1.5:1883 --keys /var/lib/romano/keys
      serves robots and people who have a key, and nobody else
  romano-broker --web 127.0.0.1:8080
      shows the fleet as a page in a browser, at http://127.0.0.1:8080/
  romano-broker --metrics 127.0.0.1:9883
      tells Prometheus and `romano status` what it counts
  romano-broker --metrics 192.168.1.5:9883 --metrics-token metrics.token --http-certificate https.pem
      also on other machines, over https, to those who have the token
  romano-broker --default-config > r1.toml; romano-broker --config r1.toml
      the same options from a file: listen = ["127.0.0.1:1883"], name = "r1", domain = 7, ...

Exit code: 0 after SIGTERM or SIGINT, 2 when a setting is not possible.)";

std::string one_line(std::string text) {
    while (!text.empty() && text.back() == '\n') text.pop_back();
    std::ranges::replace(text, '\n', ' ');
    return text;
}

void add_options(CLI::App& app, SettingTexts& texts) {
    app.add_option("--listen", texts.listen,
                   "Serve clients at this address (repeatable; default 127.0.0.1:1883, with "
                   "--allow-plain 0.0.0.0:1883); protected://ADDR:PORT for clients with keys, "
                   "dtls://ADDR:PORT for those that speak DTLS 1.2")
        ->type_name("ADDR:PORT");
    app.add_flag("--allow-plain", texts.allow_plain,
                 "Serve plain clients and plain metrics at addresses that other machines reach: "
                 "whoever can send a datagram there steers robots and reads everything");
    app.add_option(
           "--keys", texts.keys,
           "Folder with the keys of clients (romano keys new); the broker writes there, too. In a "
           "cluster also what brokers know each other by: all have one, or none")
        ->type_name("DIR");
    app.add_option("--rights", texts.rights,
                   "File that says who may publish and read what (romano rights usual prints one); "
                   "read again at SIGHUP. For all brokers of a cluster the same (default: people "
                   "with keys everything, robots their own, plain clients everything)")
        ->type_name("FILE");
    app.add_option("--name", texts.name,
                   "The broker's name, unique in its cluster (default: HOST-ADDR:PORT; on all "
                   "addresses HOST-MAC:PORT, with a hardware address of the machine)")
        ->type_name("NAME");
    app.add_option("--predefined", texts.predefined,
                   "A predefined topic id and its topic (repeatable)")
        ->type_name("ID=TOPIC");
    app.add_option("--gateway-id", texts.gateway_id, "The id in ADVERTISE and GWINFO")
        ->type_name("1..255")
        ->capture_default_str();
    app.add_option("--discovery-group", texts.discovery_group,
                   "Take part in MQTT-SN discovery in this multicast group (repeatable); "
                   "\"default\" means 225.1.1.1:1883 and [ff02::225:1:1:1]:1883")
        ->type_name("ADDR:PORT");
    app.add_option("--advertise-period", texts.advertise_period,
                   "Seconds between two ADVERTISE in the discovery groups (default 900)")
        ->type_name("1..65535");

    app.add_option("--cell-group", texts.cell_group,
                   "Send a message for many once, to this multicast group, for those clients that "
                   "say that they listen there (romano-robot --cell-group); all others, and "
                   "clients with keys, get it alone as ever")
        ->type_name("ADDR:PORT");

    app.add_flag("--no-romano", texts.no_romano,
                 "Carry no ROMANO server: robots' connection requests go unanswered");

    const std::string store = "Store";
    app.add_option("--store", texts.store,
                   "Keep sessions, retained and queued messages in this file; for a broker alone")
        ->type_name("PATH")
        ->group(store);
    app.add_option("--store-limit-mb", texts.store_limit_mb,
                   "Largest size of that file in MiB; beyond it clients hear \"congestion\" "
                   "(default 1024)")
        ->type_name("MIB")
        ->group(store);
    app.add_flag("--store-sync", texts.store_sync,
                 "Wait for the medium before each promise: survives a power cut too, but slower")
        ->group(store);

    for (const LimitSetting& setting : limit_settings()) {
        app.add_option(std::string("--") + setting.key, texts.limits.at(setting.key), setting.help)
            ->type_name("N")
            ->capture_default_str()
            ->group("Limits");
    }

    const std::string cluster = "Cluster";
    app.add_option("--domain", texts.domain,
                   "Be a member of the cluster on this DDS domain (without it: alone)")
        ->type_name("0..230")
        ->group(cluster);
    app.add_option("--interface", texts.interface,
                   "Network interface between the brokers (default: DDS chooses)")
        ->type_name("IF")
        ->group(cluster);
    app.add_flag("--plain-peers", texts.plain_peers,
                 "Speak with other brokers unprotected, although there are --keys: whoever reaches "
                 "their network can join")
        ->group(cluster);
    app.add_option("--rank", texts.rank, "Capability: the highest rank leads")
        ->type_name("N")
        ->capture_default_str()
        ->group(cluster);
    app.add_option("--condition-file", texts.condition_file,
                   "Battery or load, from 0 (spent) to 100 (full, or idle), read each second: of "
                   "brokers of one rank the highest leads; for example "
                   "/sys/class/power_supply/BAT0/capacity (default: 100)")
        ->type_name("FILE")
        ->group(cluster);
    app.add_option("--acks", texts.acks,
                   "Peers that must hold an event before a client sees its effect")
        ->type_name("N|all")
        ->capture_default_str()
        ->group(cluster);
    app.add_option("--elector", texts.elector, "Election algorithm")
        ->type_name("NAME")
        ->capture_default_str()
        ->group(cluster);
    app.add_option("--voters", texts.voters,
                   "raft: the names of all brokers that vote, this one or not, such as r1,r2,r3")
        ->type_name("NAME,...")
        ->group(cluster);
    app.add_option("--detector", texts.detector,
                   "Failure detector: link knows of a crash at once; silence is left to beacons")
        ->type_name("NAME")
        ->capture_default_str()
        ->group(cluster);

    const std::string uplink = "Uplink (held by the broker that leads the cluster)";
    app.add_option("--uplink", texts.uplink,
                   "Exchange topics with this MQTT 5 broker (default ports 1883 and 8883)")
        ->type_name("mqtt[s]://HOST[:PORT]")
        ->group(uplink);
    app.add_option(
           "--uplink-network", texts.uplink_network,
           "Names this network of robots there: the same at all its brokers, different from "
           "other networks")
        ->type_name("NAME")
        ->group(uplink);
    app.add_option("--uplink-topic", texts.uplink_topic,
                   "What is exchanged (repeatable), as mosquitto's bridges write it: PATTERN "
                   "[out|in|both] [QOS] [LOCAL-PREFIX] [REMOTE-PREFIX]; unless said, both at QoS 2")
        ->type_name("RULE")
        ->group(uplink);
    app.add_option("--uplink-ca", texts.uplink_ca,
                   "mqtts: certificates that sign the MQTT broker's (default: the system's)")
        ->type_name("FILE")
        ->group(uplink);
    app.add_option("--uplink-username", texts.uplink_username, "User name at the MQTT broker")
        ->type_name("NAME")
        ->group(uplink);
    app.add_option("--uplink-password-file", texts.uplink_password_file,
                   "File whose first line is the password there")
        ->type_name("FILE")
        ->group(uplink);

    const std::string ros2 = "ROS 2 (bridged by the broker that leads the cluster)";
    app.add_option("--ros2-domain", texts.ros2_domain,
                   "Bridge topics to ROS 2 nodes with this ROS_DOMAIN_ID")
        ->type_name("0..230")
        ->group(ros2);
    app.add_option("--ros2-rules", texts.ros2_rules,
                   "What is bridged, a rule a line: DIRECTION ROMANO-TOPIC ROS-TOPIC TYPE "
                   "[KEY=VALUE ...], for example: out robots/+/telemetry /robot_+/odom "
                   "nav_msgs/msg/Odometry frame=odom")
        ->type_name("FILE")
        ->group(ros2);
    app.add_option("--ros2-interface", texts.ros2_interface,
                   "Network interface towards ROS 2 (default: that of --interface)")
        ->type_name("IF")
        ->group(ros2);
    app.add_option("--ros2-release", texts.ros2_release,
                   "ROS 2 release of the nodes there: humble, iron or jazzy")
        ->type_name("NAME")
        ->capture_default_str()
        ->group(ros2);

    const std::string times = "Times (--profile sets them together: lan, wifi or mesh)";
    app.add_option("--profile", texts.profile, "The network that the brokers share")
        ->type_name("NAME")
        ->capture_default_str()
        ->group(times);
    app.add_option("--beacon-ms", texts.beacon_ms, "Time between two beacons")
        ->type_name("MS")
        ->group(times);
    app.add_option("--detection-timeout-ms", texts.detection_timeout_ms,
                   "Silence after which a peer is taken for dead")
        ->type_name("MS")
        ->group(times);
    app.add_option("--phi-threshold", texts.phi_threshold,
                   "phi-accrual: suspicion, as -log10 of the chance that it is wrong")
        ->type_name("PHI")
        ->group(times);
    app.add_option("--retry-ms", texts.retry_ms, "Tretry: an unanswered client is asked again")
        ->type_name("MS")
        ->group(times);
    app.add_option("--retries", texts.retries, "Nretry: and given up after so many times")
        ->type_name("N")
        ->group(times);
    app.add_flag("--realtime", texts.realtime,
                 "Run before other programs (SCHED_RR) and keep the memory locked: fewer false "
                 "failovers on a busy machine");

    app.add_option("--web", texts.web,
                   "Show the fleet as a page at http://ADDR:PORT/, from where robots are steered: "
                   "romano web (package romano-tools) runs beside the broker")
        ->type_name("ADDR:PORT");
    app.add_option("--web-key", texts.web_key,
                   "The page's key (romano keys new --operator), for a broker that serves clients "
                   "with keys; whoever opens the page steers with it")
        ->type_name("FILE");
    app.add_option("--web-token", texts.web_token,
                   "Serve the page, over https, to whoever shows the word in this file of mode 600 "
                   "(in a browser as the password, with any name)")
        ->type_name("FILE");
    app.add_flag("--let-everybody-steer", texts.let_everybody_steer,
                 "Serve the page to other machines too: whoever reaches it can steer all robots");
    app.add_option("--metrics", texts.metrics,
                   "Serve Prometheus metrics at http://ADDR:PORT/metrics; also for romano status")
        ->type_name("ADDR:PORT");
    app.add_option("--metrics-token", texts.metrics_token,
                   "Serve them, over https, to whoever shows the word in this file of mode 600 "
                   "(Authorization: Bearer WORD)")
        ->type_name("FILE");
    app.add_option("--http-certificate", texts.http_certificate,
                   "What proves page and metrics to others: a PEM file of mode 600 with "
                   "certificate and private key (default: broker.pem in the folder of --keys)")
        ->type_name("FILE");
    app.add_option("--log-level", texts.log_level,
                   "Trace on stderr: trace, debug, info, warn, error or off")
        ->type_name("LEVEL")
        ->capture_default_str();
}

/// Throws Refusal for what the file says; the rest are CLI11's own exceptions.
void parse(CLI::App& app, const CLI::Option& config, int argc, const char* const* argv) {
    try {
        app.parse(argc, argv);
    } catch (const Refusal& refused) {
        throw Refusal("--config '" + config.as<std::string>() + "': " + refused.what());
    } catch (const CLI::FileError&) {
        throw Refusal("--config '" + config.as<std::string>() +
                      "': the file cannot be read; give a TOML file");
    }
}

}  // namespace

std::variant<SettingTexts, Information> read_command_line(int argc, const char* const* argv) {
    CLI::App app{"An MQTT-SN 1.2 broker over UDP, alone or as one of a cluster.", "romano-broker"};
    app.footer(examples);
    app.set_version_flag("--version", "romano-broker " ROMANO_VERSION);
    app.get_formatter()->column_width(38);
    SettingTexts texts;
    add_options(app, texts);
    CLI::Option* config = app.set_config("--config", "", "Read settings from this TOML file");
    config->type_name("FILE");
    app.config_formatter(std::make_shared<ConfigFile>(app));
    bool wants_default_config = false;
    app.add_flag("--default-config", wants_default_config,
                 "Print a commented configuration file with all defaults and exit");
    try {
        parse(app, *config, argc, argv);
    } catch (const CLI::CallForVersion& version) {
        return Information{std::string(version.what()) + "\n"};
    } catch (const CLI::Success&) {
        return Information{app.help()};
    } catch (const CLI::ParseError& error) {
        throw Refusal(one_line(error.what()) + "; romano-broker --help lists the settings");
    }
    if (wants_default_config) return Information{default_config(app)};
    return texts;
}

}  // namespace romano::daemon
