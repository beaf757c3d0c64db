#include "experiments/cli/broker_options.h"

#include <unistd.h>

#include <cmath>

#include "romano/cli/real_number.h"
#include "romano/keys/key_error.h"
#include "romano/mqttsn/topic.h"

namespace romano::experiments {

void BrokerOptions::add_to(CLI::App& command) {
    // -h is the host, as mosquitto's users know it.
    command.set_help_flag("--help", "Show this and examples, and exit");
    command.add_option("-h,--host", host, "The broker: a name, an IPv4 or an IPv6 address")
        ->capture_default_str();
    command.add_option("-p,--port", port, "Its UDP port")
        ->check(CLI::Range(1, 65535))
        ->capture_default_str();
    command.add_option("-i,--id", client_id, "Client id (default: one is made up)");
    command.add_option("-k,--keepalive", keep_alive_s, "Keep-alive in seconds, 0 for none")
        ->check(CLI::Range(0, 65535))
        ->capture_default_str();
    command
        .add_option("--broker-timeout", timeout_s,
                    "Seconds within which the broker must answer, with 4 attempts")
        ->check(real_number(0.1, 3600.0))
        ->capture_default_str();
}

void BrokerOptions::add_key_to(CLI::App& command) {
    command
        .add_option("--key", key_file,
                    "Own key, for a broker with protected:// addresses (romano keys new)")
        ->type_name("FILE");
    command
        .add_flag("--dtls", speaks_dtls,
                  "Speak DTLS 1.2 with the key, for a broker with dtls:// addresses")
        ->needs("--key");
}

std::shared_ptr<keys::ClientPackets> BrokerOptions::packets() const {
    if (packets_ || key_file.empty()) return packets_;
    try {
        packets_ = std::make_shared<keys::ClientPackets>(
            key_file, client_id, speaks_dtls ? keys::Speech::dtls : keys::Speech::packets);
    } catch (const keys::KeyError& error) {
        throw CommandError("--key: " + std::string{error.what()});
    }
    return packets_;
}

std::string BrokerOptions::id_or(const char* made_up) const {
    if (const auto own = packets()) return own->client_id();
    return client_id.empty() ? std::string{made_up} + "-" + std::to_string(::getpid()) : client_id;
}

client::Timing BrokerOptions::timing() const {
    client::Timing timing;
    timing.n_retry = 3;
    timing.t_retry =
        std::chrono::duration_cast<Duration>(std::chrono::duration<double>{timeout_s / 4});
    return timing;
}

std::string BrokerOptions::where() const {
    return host + " port " + std::to_string(port);
}

std::string BrokerOptions::unreachable(bool was_refused) const {
    if (was_refused) {
        return "no broker serves at " + where() + ": nobody listens there (see -h and -p)";
    }
    if (!key_file.empty()) {
        return "no broker answered at " + where() + ": does it serve " +
               (speaks_dtls ? "dtls" : "protected") + ":// there, with this key in its table?";
    }
    return "no broker answered at " + where() +
           " (see -h, -p, --key, --broker-timeout; a broker that waits for its peers, or for a "
           "leader, answers nobody: its trace says so)";
}

void check_filters(const std::vector<std::string>& filters) {
    for (const std::string& filter : filters) {
        if (mqttsn::is_valid_topic_filter(filter)) continue;
        throw CommandError("--topics `" + filter + "`: must be a topic filter such as # or a/+/b");
    }
}

void TopicOption::add_to(CLI::App& command, const char* what) {
    command.add_option("-t,--topic", name, what);
    command
        .add_option("--predefined", predefined,
                    "The topic by its predefined id (1 to 65534) instead of a name")
        ->check(CLI::Range(1, 65534));
    command.add_flag("--short", is_short, "The topic's name of two octets is a short topic name");
}

mqttsn::TopicRef TopicOption::topic() const {
    if (name.empty() == (predefined == 0)) {
        throw CommandError("a topic is needed: either -t NAME or --predefined ID");
    }
    if (predefined != 0) return client::predefined_topic(mqttsn::TopicId{predefined});
    if (is_short && name.size() != 2) {
        throw CommandError("--short with -t `" + name + "`: a short topic name has two octets");
    }
    return is_short ? client::short_topic(name) : client::topic_name(name);
}

std::string TopicOption::words() const {
    if (predefined == 0) return "`" + name + "`";
    return "predefined topic id " + std::to_string(predefined);
}

}  // namespace romano::experiments
