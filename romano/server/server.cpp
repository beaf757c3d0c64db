#include "romano/server/server.h"

#include <algorithm>
#include <set>
#include <variant>

#include "romano/message/codec.h"
#include "romano/server/legacy.h"

namespace romano::server {

using namespace std::chrono_literals;
using message::RomanoId;

namespace {

constexpr Duration shortest_patience{2s};
constexpr Duration long_ago{1h};  // longer than any patience
constexpr std::size_t entries_a_look = 1000;

void publish(Host& host, std::string_view topic, const message::Message& message) {
    std::array<std::uint8_t, message::max_message> octets{};
    const std::size_t size = message::encode(message, octets);
    host.publish(topic, Bytes{octets}.first(size), false);
}

}  // namespace

bool is_never_retained(std::string_view topic, Bytes data) {
    if (message::flaw_of(data)) {
        const bool is_robots = topic == common_topic || RomanoId::parse(topic);
        return is_robots && legacy::is_movement(data);
    }
    return message::is_movement(message::DataType{data[0]});
}

void ServerCore::on_publish(Instant now, std::string_view client, std::string_view topic,
                            Bytes data, Host& host) {
    if (topic == init_topic) {
        on_binary_request(now, client, data, host);
    } else if (topic == legacy_init_topic) {
        on_legacy_request(now, client, data, host);
    } else {
        on_heartbeat(now, client, data, host);
    }
}

void ServerCore::on_binary_request(Instant now, std::string_view client, Bytes data, Host& host) {
    const auto message = message::decode(data);
    if (!message) {
        ++counters_.malformed;
    } else if (const auto* request = std::get_if<message::ConnectionRequest>(&*message)) {
        welcome(now, request->sender, client, Form::binary, host);
    } else if (const auto* wish = std::get_if<message::RequestConnectedNodes>(&*message)) {
        send_list(wish->asker, host);
    }
}

void ServerCore::on_legacy_request(Instant now, std::string_view client, Bytes data, Host& host) {
    const auto request = legacy::parse(data);
    if (!request) {
        ++counters_.malformed;
    } else if (request->kind == legacy::Request::Kind::hello) {
        welcome(now, *request->id, client, Form::legacy, host);
    } else if (request->kind == legacy::Request::Kind::list) {
        send_legacy_list(client, host);
    }  // a turn of the RSSI game is between its players
}

void ServerCore::welcome(Instant now, const RomanoId& id, std::string_view client, Form form,
                         Host& host) {
    if (!nodes_.contains(id) && nodes_.size() >= options_.most_nodes) {
        ++counters_.refused;
        return;
    }
    Node& node = nodes_[id];
    if (node.heartbeat) node.heartbeat = now;
    NodeEntry entry = node.told;
    entry.id = id;
    entry.form = form;
    entry.state = NodeState::connected;
    entry.home = options_.name;
    entry.client = client;
    if (entry != node.told) tell(now, node, entry, host);
    host.hold(client, false);
    ++counters_.acknowledged;
    if (form == Form::legacy) {
        host.publish(id.text(), as_octets(legacy::acknowledgement), false);
    } else {
        publish(host, id.text(), message::ConnectionAck{});
    }
}

void ServerCore::send_list(const RomanoId& asker, Host& host) {
    std::string ids;
    const auto send = [&] {
        publish(host, asker.text(), message::ConnectedNodes{as_octets(ids)});
        ids.clear();
    };
    for (const NodeEntry& entry : host.entries()) {
        if (entry.state != NodeState::connected) continue;
        ids += entry.id.text();
        if (ids.size() == message::max_ids_in_message * RomanoId::size) send();
    }
    send();  // a message with fewer than it could hold ends the list
    ++counters_.lists_sent;
}

/// The firmware's request has no id in it, but its client id is one.
void ServerCore::send_legacy_list(std::string_view asker, Host& host) {
    if (!RomanoId::parse(asker)) {
        ++counters_.malformed;
        return;
    }
    std::vector<NodeEntry> entries = host.entries();
    std::erase_if(entries, [](const auto& entry) { return entry.state != NodeState::connected; });
    host.publish(asker, legacy::count_message(entries.size()), false);
    for (const NodeEntry& entry : entries) {
        host.publish(asker, legacy::node_message(entry.id), false);
    }
    ++counters_.lists_sent;
}

void ServerCore::on_heartbeat(Instant now, std::string_view client, Bytes data, Host& host) {
    const auto message = message::decode(data);
    const auto* beat = message ? std::get_if<message::Heartbeat>(&*message) : nullptr;
    if (beat == nullptr) return;  // everything else on `common` is between the nodes
    const auto found = nodes_.find(beat->sender);
    if (found == nodes_.end() || found->second.told.client != client) return;
    Node& node = found->second;
    const bool was_silent = node.told.state == NodeState::silent;
    if (node.heartbeat && !was_silent) {
        node.interval = std::max(now - *node.heartbeat, node.interval / 2);
    }
    node.heartbeat = now;
    if (was_silent || node.told.heartbeat_unix_ms == 0) {
        NodeEntry entry = node.told;
        entry.state = NodeState::connected;
        tell(now, node, entry, host);
        host.hold(client, false);
    }
}

bool ServerCore::is_silent(const Node& node, Instant now) const {
    if (!node.heartbeat) return false;
    const Duration patience = node.interval == Duration{0}
                                  ? options_.first_heartbeats_within
                                  : std::max(3 * node.interval, shortest_patience);
    return now - *node.heartbeat > patience;
}

void ServerCore::tell(Instant now, Node& node, const NodeEntry& entry, Host& host) {
    node.told = entry;
    node.told_at = now;
    if (node.heartbeat && *node.heartbeat > now - long_ago) {
        node.told.heartbeat_unix_ms = unix_ms(*node.heartbeat);
    }
    host.publish(entry_topic(entry.id), as_octets(to_text(node.told)), true);
}

void ServerCore::forget(const RomanoId& id, Host& host) {
    nodes_.erase(id);
    host.publish(entry_topic(id), {}, true);
}

std::uint64_t ServerCore::unix_ms(Instant instant) const {
    const auto since_epoch = instant.time_since_epoch() + options_.unix_time_at_zero;
    return static_cast<std::uint64_t>(
        std::chrono::duration_cast<std::chrono::milliseconds>(since_epoch).count());
}

void ServerCore::on_tick(Instant now, Host& host) {
    if (now >= look_at_) look_at_entries(now, host);
}

/// The entries follow the sessions, whatever happened to both: a session that was adopted, handed
/// over or ended; an entry that the other side of a partition wrote or deleted.
void ServerCore::look_at_entries(Instant now, Host& host) {
    const std::vector<NodeEntry> entries = host.entries();
    // Many entries are looked at more rarely, so that the looks never take much of the time.
    look_at_ = now + options_.look_every * static_cast<int>(1 + entries.size() / entries_a_look);
    std::set<RomanoId> seen;
    for (const NodeEntry& entry : entries) {
        seen.insert(entry.id);
        if (look_at(now, entry, host)) {
            unclaimed_.erase(entry.id);
        } else {
            nodes_.erase(entry.id);
            look_at_stranger(now, entry, host);
        }
    }
    std::erase_if(unclaimed_, [&](const auto& item) { return !seen.contains(item.first); });
    for (auto at = nodes_.begin(); at != nodes_.end();) {
        auto& [id, node] = *at;
        const auto standing = seen.contains(id) ? std::nullopt : host.standing(node.told.client);
        if (standing && (standing->connected || standing->kept)) {
            tell(now, node, node.told, host);
        } else if (!seen.contains(id)) {
            at = nodes_.erase(at);
            continue;
        }
        ++at;
    }
}

bool ServerCore::look_at(Instant now, const NodeEntry& entry, Host& host) {
    const auto standing = host.standing(entry.client);
    if (!standing) return false;
    if (!standing->connected && !standing->kept) {
        forget(entry.id, host);
        return true;
    }
    const auto [at, is_new] = nodes_.try_emplace(entry.id);
    Node& node = at->second;
    if (is_new && entry.heartbeat_unix_ms != 0) {
        node.heartbeat = entry.state == NodeState::silent ? now - long_ago : now;
    }
    if (is_new) node.told_at = now;
    node.told = entry;
    NodeEntry wanted = entry;
    wanted.home = options_.name;
    wanted.state = !standing->connected   ? NodeState::away
                   : is_silent(node, now) ? NodeState::silent
                                          : NodeState::connected;
    const bool is_stale = node.heartbeat && now - node.told_at >= options_.heartbeat_told_every &&
                          wanted.state == NodeState::connected;
    if (wanted != entry || is_stale) tell(now, node, wanted, host);
    host.hold(entry.client, wanted.state == NodeState::silent);
    return true;
}

void ServerCore::look_at_stranger(Instant now, const NodeEntry& entry, Host& host) {
    if (entry.home != options_.name && !host.tidies_up_after(entry.home)) {
        unclaimed_.erase(entry.id);
        return;
    }
    const Instant since = unclaimed_.try_emplace(entry.id, now).first->second;
    if (now - since < options_.unclaimed_for) return;
    unclaimed_.erase(entry.id);
    forget(entry.id, host);
}

}  // namespace romano::server
