#include "broker/protection/protected_clients.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "broker/protection/client_names.h"
#include "broker/protection/protected_node.h"
#include "romano/mqttsn/decode.h"

namespace romano::broker {

using mqttsn::MsgType;
using protection::BrokerEnd;
using protection::Heard;
using protection::Refusal;
using protection::Reserve;
using protection::SenderId;

namespace {

// In front of a message there is room for the header of its packet, and for that of its forwarder.
constexpr std::size_t room_in_front = 256;

void add_refusals(const BrokerEnd& end, ProtectionCounters& to) {
    for (std::size_t kind = 0; kind < protection::refusal_kinds; ++kind) {
        to.refused[kind] += end.refusals().of(static_cast<Refusal>(kind));
    }
}

/// What was stored is the end of a block; who told us knows where in that block the client is.
bool is_in_last_block(const Heard& stored, const Heard& told) {
    return stored.run == told.run && told.floor + protection::numbers_a_block > stored.floor;
}

}  // namespace

struct ProtectedClients::Client {
    Client(const ProtectedClient& who, const SenderId& self, Reserve& reserve,
           std::optional<Heard> heard)
        : id(who.client_id),
          key(who.key),
          node_id(protected_node_id(id)),
          keys(protection::direction_keys(key)),
          sender(protection::sender_id(id)),
          end(std::in_place, keys, id, self, reserve, heard),
          is_rounded(heard && heard->floor == Reserve::block_of(heard->floor)) {}

    const std::string id;
    const protection::RobotKey key;
    const std::string node_id;
    const protection::DirectionKeys keys;
    const SenderId sender;
    std::optional<BrokerEnd> end;  // always there; made anew when another broker knows more
    bool is_to_tell = false;
    bool is_rounded;  // what is known is the end of a block, as it was stored
};

std::size_t ProtectedClients::SenderHash::operator()(const SenderId& id) const {
    std::size_t hash = 0;
    static_assert(sizeof hash <= std::tuple_size_v<SenderId>);
    std::memcpy(&hash, id.data(), sizeof hash);
    return hash;
}

ProtectedClients::ProtectedClients(const SenderId& self, std::uint32_t bound,
                                   std::size_t stranger_answers_per_second)
    : self_(self),
      reserve_(bound),
      answers_(stranger_answers_per_second),
      room_(room_in_front + mqttsn::max_datagram) {}
ProtectedClients::~ProtectedClients() = default;

void ProtectedClients::set_clients(std::span<const ProtectedClient> clients, const Known& known) {
    std::unordered_map<std::string_view, const ProtectedClient*> wanted;
    for (const ProtectedClient& client : clients) wanted.emplace(client.client_id, &client);
    std::erase_if(by_id_, [&](const auto& entry) {
        Client& client = *entry.second;
        const auto found = wanted.find(client.id);
        if (found != wanted.end() && found->second->key.octets == client.key.octets) return false;
        forget(client);
        return true;
    });
    for (const ProtectedClient& each : clients) {
        if (by_id_.contains(each.client_id)) continue;
        const auto heard = known ? known(protection::sender_id(each.client_id)) : std::nullopt;
        auto client = std::make_unique<Client>(each, self_, reserve_, heard);
        by_sender_.insert_or_assign(client->sender, client.get());
        const std::string_view id = client->id;
        by_id_.emplace(id, std::move(client));
    }
}

void ProtectedClients::forget(Client& client) {
    add_refusals(*client.end, counters_);
    const auto found = by_sender_.find(client.sender);
    if (found != by_sender_.end() && found->second == &client) by_sender_.erase(found);
    std::erase(to_tell_, &client);
    if (to_store_ == &client) to_store_ = nullptr;
}

// --- in

Bytes ProtectedClients::admit(Instant now, const Endpoint& via, const Endpoint& from,
                              Bytes datagram, Actions& out) {
    to_store_ = nullptr;
    return is_sealed(via) ? admit_sealed(via, from, datagram, out)
                          : admit_plain(now, via, from, datagram, out);
}

Bytes ProtectedClients::admit_sealed(const Endpoint& via, const Endpoint& from, Bytes datagram,
                                     Actions& out) {
    const auto frame = mqttsn::decode_frame(datagram);
    if (frame && frame->type == MsgType::searchgw) return datagram;  // a hint to anybody
    if (datagram.size() > mqttsn::max_datagram) {
        count(Refusal::malformed);
        return {};
    }
    std::copy(datagram.begin(), datagram.end(), room_.begin() + room_in_front);
    const MutableBytes packet = MutableBytes{room_}.subspan(room_in_front, datagram.size());
    const auto parsed = protection::parse(packet);
    if (!parsed) {
        count(parsed.error());
        return {};
    }
    const auto found = by_sender_.find(parsed->fields().sender);
    if (found == by_sender_.end()) {
        count(Refusal::unknown_sender);
        return {};
    }
    Client& client = *found->second;
    const Bytes message = client.end->open(packet);
    if (message.empty()) return {};
    ++counters_.opened;
    note(client);
    if (!is_own_name(client.id, message)) {
        ++counters_.foreign_client_id;
        if (mqttsn::decode_frame(message)->type == MsgType::connect) {
            refuse_connect(via, {from, client.node_id}, out);
        }
        return {};
    }
    // The forwarder's header goes in front of the message where it lies.
    const std::size_t header = node_id_octets(client.node_id);
    const auto at = static_cast<std::size_t>(message.data() - room_.data()) - header;
    put_node_id(client.node_id, MutableBytes{room_}.subspan(at, header));
    return Bytes{room_}.subspan(at, header + message.size());
}

Bytes ProtectedClients::admit_plain(Instant now, const Endpoint& via, const Endpoint& from,
                                    Bytes datagram, Actions& out) {
    auto frame = mqttsn::decode_frame(datagram);
    if (!frame) return datagram;
    ClientAddress sender{from, {}};
    if (frame->type == MsgType::encapsulated) {
        const auto wrapped = mqttsn::decode_encapsulated(*frame);
        if (!wrapped) return datagram;
        const std::string_view node_id = as_text(wrapped->wireless_node_id);
        if (node_id.starts_with(protected_mark)) {
            ++counters_.needs_protection;
            return {};
        }
        frame = mqttsn::decode_frame(wrapped->message);
        if (!frame) return datagram;
        if (frame->type != MsgType::connect && frame->type != MsgType::pingreq) return datagram;
        sender.wireless_node_id = node_id;
    }
    const auto named = named_client(*frame);
    if (!named || !by_id_.contains(*named)) return datagram;
    const bool is_answered = frame->type == MsgType::connect;
    if (is_answered && !answers_.allows(now)) {
        ++counters_.stranger_rate;
        return {};
    }
    ++counters_.needs_protection;
    if (is_answered) refuse_connect(via, sender, out);
    return {};
}

void ProtectedClients::note(Client& client) {
    to_store_ = &client;
    client.is_rounded = false;
    if (std::exchange(client.is_to_tell, true)) return;
    to_tell_.push_back(&client);
}

std::optional<PacketsHeard> ProtectedClients::to_store() const {
    if (to_store_ == nullptr) return std::nullopt;
    const auto heard = to_store_->end->to_store();
    if (!heard) return std::nullopt;
    return PacketsHeard{to_store_->sender, *heard};
}

void ProtectedClients::on_stored() {
    to_store_->end->on_stored(*to_store_->end->to_store());
}

// --- out

void ProtectedClients::seal(Actions& actions) {
    for (Action& action : actions.list()) {
        auto* send = std::get_if<Send>(&action);
        if (send == nullptr || !is_sealed(send->via)) continue;
        const std::string_view node_id = send->to.wireless_node_id;
        if (!node_id.starts_with(protected_mark)) continue;  // an answer to SEARCHGW
        const auto found = by_id_.find(node_id.substr(protected_mark.size()));
        if (found == by_id_.end()) {
            ++counters_.keyless;
            send->via = {};
            continue;
        }
        const MutableBytes out = actions.reserve(send->size + protection::most_overhead);
        const Bytes wrapped = actions.octets(*send);
        const std::size_t size = found->second->end->seal(wrapped.subspan(wrapped[0]), out);
        send->offset = actions.commit(size);
        send->size = static_cast<std::uint32_t>(size);
        if (size == 0) {
            send->via = {};
        } else {
            ++counters_.sealed;
        }
    }
}

// --- several brokers

std::vector<PacketsHeard> ProtectedClients::to_tell() {
    std::vector<PacketsHeard> told;
    told.reserve(to_tell_.size());
    for (Client* client : to_tell_) {
        client->is_to_tell = false;
        if (const auto heard = client->end->heard()) told.push_back({client->sender, *heard});
    }
    to_tell_.clear();
    return told;
}

void ProtectedClients::tell_all() {
    for (const auto& [id, client] : by_id_) {
        if (!client->end->heard() || client->is_rounded) continue;
        if (std::exchange(client->is_to_tell, true)) continue;
        to_tell_.push_back(client.get());
    }
}

void ProtectedClients::on_told(std::span<const PacketsHeard> told) {
    for (const PacketsHeard& each : told) {
        const auto found = by_sender_.find(each.sender);
        if (found == by_sender_.end() || each.heard.floor >= protection::max_number) continue;
        Client& client = *found->second;
        const auto own = client.end->heard();
        const bool is_more_exact = client.is_rounded && is_in_last_block(*own, each.heard);
        if (own && each.heard.floor <= own->floor && !is_more_exact) continue;
        client.is_rounded = false;
        add_refusals(*client.end, counters_);
        client.end.emplace(client.keys, client.id, self_, reserve_, each.heard);
    }
}

std::vector<PacketsHeard> ProtectedClients::heard() const {
    std::vector<PacketsHeard> all;
    for (const auto& [id, client] : by_id_) {
        if (const auto heard = client->end->heard()) all.push_back({client->sender, *heard});
    }
    return all;
}

ProtectionCounters ProtectedClients::counters() const {
    ProtectionCounters sum = counters_;
    for (const auto& [id, client] : by_id_) add_refusals(*client->end, sum);
    return sum;
}

}  // namespace romano::broker
