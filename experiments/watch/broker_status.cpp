#include "experiments/watch/broker_status.h"

#include <nlohmann/json.hpp>

namespace romano::experiments {
namespace {

using nlohmann::json;

void read(const json& object, const char* key, std::optional<std::uint64_t>& value) {
    if (const auto found = object.find(key); found != object.end() && !found->is_null()) {
        value = found->get<std::uint64_t>();
    }
}

template <typename Value>
void read(const json& object, const char* key, Value& value) {
    if (const auto found = object.find(key); found != object.end() && !found->is_null()) {
        value = found->get<Value>();
    }
}

}  // namespace

std::optional<BrokerStatus> parse_broker_status(std::string_view text) {
    try {
        const json object = json::parse(text);
        BrokerStatus status;
        status.name = object.at("name").get<std::string>();
        read(object, "alive", status.alive);
        read(object, "leader", status.leader);
        read(object, "rank", status.rank);
        read(object, "condition", status.condition);
        read(object, "sessions", status.sessions);
        read(object, "connected", status.connected);
        read(object, "addresses", status.addresses);
        read(object, "cannot_take", status.cannot_take);
        read(object, "incarnation", status.incarnation);
        read(object, "transport_octets_sent", status.transport_octets_sent);
        read(object, "rights", status.rights);
        read(object, "longest_turn_us", status.longest_turn_us);
        read(object, "cpu_percent", status.cpu_percent);
        read(object, "does_not_hear", status.does_not_hear);
        read(object, "disagrees", status.disagrees);
        if (const auto view = object.find("view"); view != object.end() && view->is_object()) {
            read(*view, "term", status.view_term);
            read(*view, "leader", status.view_leader);
            read(*view, "members", status.view_members);
        }
        return status;
    } catch (const json::exception&) {
        return std::nullopt;
    }
}

}  // namespace romano::experiments
