#include "tests/conformance/broker.h"

#include <gtest/gtest.h>

#include <array>
#include <sstream>

#include "broker/net/endpoint_text.h"
#include "tests/system/process.h"

namespace romano::conformance {
namespace {

std::string number(std::size_t value) {
    return std::to_string(value);
}

std::vector<std::string> arguments_of(Kind kind) {
    const Agreement& agreed = agreement();
    std::vector<std::string> arguments{
        "--listen",    "127.0.0.1:0",  "--listen",
        "[::1]:0",     "--predefined", number(agreed.predefined_id) + "=" + agreed.predefined_topic,
        "--log-level", "off"};
    const auto add = [&arguments](std::vector<std::string> more) {
        arguments.insert(arguments.end(), more.begin(), more.end());
    };
    switch (kind) {
        case Kind::patient:
            add({"--retry-ms", "60000"});
            break;
        case Kind::impatient:
            add({"--retry-ms", "100", "--retries", "3"});
            break;
        case Kind::narrow:
            add({"--retry-ms", "60000", "--no-romano"});
            add({"--max-sessions", number(Narrow::sessions)});
            add({"--session-expiry-s", number(Narrow::session_expiry_s)});
            add({"--max-connecting", number(Narrow::connecting)});
            add({"--max-subscriptions", number(Narrow::subscriptions)});
            add({"--max-topics", number(Narrow::topics)});
            add({"--max-queued", number(Narrow::queued)});
            add({"--max-retained", number(Narrow::retained)});
            add({"--max-unreleased", number(Narrow::unreleased)});
            add({"--max-payload-octets", number(Narrow::payload_octets)});
            add({"--max-client-id-octets", number(Narrow::client_id_octets)});
            break;
    }
    return arguments;
}

class OwnBroker {
public:
    explicit OwnBroker(Kind kind) : process_(ROMANO_BROKER, arguments_of(kind)) {
        // "romano-broker NAME: serving A, B"
        std::string line = process_.next_line();
        const std::size_t serving = line.find("serving ");
        if (serving == std::string::npos) ADD_FAILURE() << line << process_.errors();
        std::istringstream addresses(line.substr(std::min(line.size(), serving + 8)));
        for (std::string address; addresses >> address;) {
            if (address.back() == ',') address.pop_back();
            if (const auto endpoint = net::parse_endpoint(address)) addresses_.push_back(*endpoint);
        }
    }

    [[nodiscard]] std::optional<Endpoint> at(Endpoint::Family family) const {
        for (const Endpoint& address : addresses_) {
            if (address.family == family) return address;
        }
        return std::nullopt;
    }

private:
    system::Process process_;
    std::vector<Endpoint> addresses_;
};

}  // namespace

Agreement& agreement() {
    static Agreement agreed;
    return agreed;
}

std::optional<Endpoint> broker_at(Kind kind, Endpoint::Family family) {
    if (const auto& address = agreement().address) {
        const bool serves = address->family == family && kind != Kind::narrow;
        return serves ? address : std::nullopt;
    }
    static std::array<std::unique_ptr<OwnBroker>, 3> brokers;
    auto& broker = brokers.at(static_cast<std::size_t>(kind));
    if (broker == nullptr) broker = std::make_unique<OwnBroker>(kind);
    return broker->at(family);
}

}  // namespace romano::conformance
