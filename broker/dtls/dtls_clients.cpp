#include "broker/dtls/dtls_clients.h"

#include <algorithm>
#include <array>
#include <utility>

#include "broker/dtls/own_id.h"
#include "broker/protection/client_names.h"
#include "broker/protection/protected_node.h"
#include "romano/dtls/record/alert.h"
#include "romano/mqttsn/decode.h"

namespace romano::dtls {

using broker::Send;
using mqttsn::MsgType;

namespace {

constexpr std::size_t most_associations = 2;  // of a client
// In front of a message there is room for the header of its forwarder.
constexpr std::size_t room_in_front = 256;

// PINGREQ: whoever is there answers it (MQTT-SN 1.2 section 6.11).
constexpr std::array<std::uint8_t, 2> are_you_there{2, static_cast<std::uint8_t>(MsgType::pingreq)};

bool is_pong(Bytes message) {
    const auto frame = mqttsn::decode_frame(message);
    return frame && frame->type == MsgType::pingresp;
}

}  // namespace

struct DtlsClients::Client {
    explicit Client(const broker::ProtectedClient& who)
        : id(who.client_id), key(who.key), node_id(broker::protected_node_id(id)) {}

    const std::string id;
    const protection::RobotKey key;
    const std::string node_id;
    std::vector<Entry*> entries;  // the one that was heard, or begun, last is first
};

struct DtlsClients::Entry {
    Entry(Client& whose, Association&& of) : client(whose), association(std::move(of)) {}

    Client& client;
    Association association;
    bool is_to_tell = false;
    bool is_known_to_peers = false;
};

/// A record that was opened. The message lies in the room.
struct DtlsClients::Taken {
    Entry* entry;
    Opened opened;
    bool is_newest;
};

DtlsClients::DtlsClients(const Speaker& self)
    : self_(self), room_(room_in_front + most_message + 1) {}
DtlsClients::~DtlsClients() = default;

void DtlsClients::set_clients(std::span<const broker::ProtectedClient> clients) {
    std::unordered_map<std::string_view, const broker::ProtectedClient*> wanted;
    for (const auto& client : clients) wanted.emplace(client.client_id, &client);
    std::erase_if(clients_, [&](const auto& each) {
        Client& client = *each.second;
        const auto found = wanted.find(client.id);
        if (found != wanted.end() && found->second->key.octets == client.key.octets) return false;
        while (!client.entries.empty()) erase(*client.entries.back());
        return true;
    });
    for (const auto& each : clients) {
        if (clients_.contains(each.client_id)) continue;
        auto client = std::make_unique<Client>(each);
        const std::string_view id = client->id;
        clients_.emplace(id, std::move(client));
    }
}

const protection::RobotKey* DtlsClients::key_of(std::string_view client_id) const {
    const auto found = clients_.find(client_id);
    return found == clients_.end() ? nullptr : &found->second->key;
}

// --- associations

void DtlsClients::add(const Agreed& agreed) {
    const auto found = clients_.find(agreed.client_id);
    if (found == clients_.end()) return;  // withdrawn meanwhile
    Client& client = *found->second;
    note_to_tell(put(client, Association{agreed.id, agreed.path, agreed.keys, agreed.clients_id}));
    has_news_ = true;
}

DtlsClients::Entry& DtlsClients::put(Client& client, Association&& association) {
    const auto id = static_cast<std::uint64_t>(association.id());
    if (const auto same = by_id_.find(id); same != by_id_.end()) erase(*same->second);
    if (client.entries.size() == most_associations) erase(*client.entries.back());
    auto entry = std::make_unique<Entry>(client, std::move(association));
    Entry& there = *entry;
    client.entries.insert(client.entries.begin(), &there);
    if (!there.association.may_roam()) by_path_.emplace(there.association.path(), &there);
    by_id_.emplace(id, std::move(entry));
    return there;
}

void DtlsClients::erase(Entry& entry) {
    const auto [begin, end] = by_path_.equal_range(entry.association.path());
    for (auto each = begin; each != end; ++each) {
        if (each->second != &entry) continue;
        by_path_.erase(each);
        break;
    }
    std::erase(entry.client.entries, &entry);
    std::erase(to_tell_, &entry);
    by_id_.erase(static_cast<std::uint64_t>(entry.association.id()));
}

void DtlsClients::close(Entry& entry) {
    ++counters_.closed;
    closed_.push_back({entry.association.id(), entry.association.progress(), true});
    has_news_ = true;
    erase(entry);
}

void DtlsClients::note_to_tell(Entry& entry) {
    if (!std::exchange(entry.is_to_tell, true)) to_tell_.push_back(&entry);
}

// --- in

Message DtlsClients::open(const Path& path, const Record& record, broker::Actions& out) {
    const auto taken = take(path, record);
    if (!taken) return {};
    const ContentType type = taken->opened.type;
    if (type != ContentType::application_data && type != ContentType::alert) {
        count(Refusal::malformed);  // a Finished, say, that somebody sent again
        return {};
    }
    Entry& entry = *taken->entry;
    ++counters_.opened;
    note_to_tell(entry);
    auto& entries = entry.client.entries;
    if (entries.front() != &entry) std::swap(entries.front(), entries.back());
    if (taken->is_newest && entry.association.may_roam()) {
        follow(*taken, path, record.whole.size(), out);
    }
    if (type == ContentType::application_data) {
        const Path known_at{path.via, entry.association.path().from};
        return {known_at, take_message(*taken, known_at, out)};
    }
    take_alert(*taken, path.via, out);
    return {};
}

/// RFC 9146 section 4: by its Connection ID, or by its addresses where none was agreed on.
std::optional<DtlsClients::Taken> DtlsClients::take(const Path& path, const Record& record) {
    auto why = Refusal::unknown_sender;
    std::optional<Taken> taken;
    if (!record.id.empty()) {
        const auto found = by_id_.find(static_cast<std::uint64_t>(own_id_of(record.id)));
        if (found != by_id_.end() && found->second->association.may_roam()) {
            taken = take_by(*found->second, record, why);
        }
    } else {
        // Clients behind one address, and a client that began anew from where it was, share a path.
        const auto [begin, end] = by_path_.equal_range(path);
        for (auto each = begin; each != end && !taken; ++each) {
            taken = take_by(*each->second, record, why);
        }
    }
    if (!taken) count(why);
    return taken;
}

std::optional<DtlsClients::Taken> DtlsClients::take_by(Entry& entry, const Record& record,
                                                       Refusal& why) {
    const bool is_newest = entry.association.is_newest(record.number);
    const auto opened =
        entry.association.open(cipher_, record, MutableBytes{room_}.subspan(room_in_front));
    if (opened) return Taken{&entry, *opened, is_newest};
    why = opened.error();
    return std::nullopt;
}

/// RFC 9146 section 6: where the newest record came from, there the client is; and until it has
/// answered from there, little is sent.
void DtlsClients::follow(const Taken& taken, const Path& path, std::size_t octets,
                         broker::Actions& out) {
    Association& association = taken.entry->association;
    if (association.on_newest_from(path.from, octets)) {
        ++counters_.moved;
        taken.entry->is_known_to_peers = false;
        has_news_ = true;
    } else if (is_pong(Bytes{room_}.subspan(room_in_front, taken.opened.size))) {
        association.on_answered();
    }
    const bool says_goodbye = taken.opened.type == ContentType::alert;
    if (association.has_answered() || says_goodbye) return;
    say(*taken.entry, ContentType::application_data, are_you_there, path.via, out);
}

Bytes DtlsClients::take_message(const Taken& taken, const Path& path, broker::Actions& out) {
    const Client& client = taken.entry->client;
    const std::size_t size = taken.opened.size;
    const Bytes message = Bytes{room_}.subspan(room_in_front, size);
    if (message.empty()) return {};
    const auto frame = mqttsn::decode_frame(message);
    if (frame && frame->type == MsgType::encapsulated) {
        count(Refusal::forwarded);
        return {};
    }
    if (!broker::is_own_name(client.id, message)) {
        count(Refusal::foreign_client_id);
        if (frame->type == MsgType::connect) {
            broker::refuse_connect(path.via, {path.from, client.node_id}, out);
        }
        return {};
    }
    const std::size_t header = broker::node_id_octets(client.node_id);
    broker::put_node_id(client.node_id,
                        MutableBytes{room_}.subspan(room_in_front - header, header));
    return Bytes{room_}.subspan(room_in_front - header, header + size);
}

void DtlsClients::take_alert(const Taken& taken, const Endpoint& via, broker::Actions& out) {
    const auto alert = alert_in(Bytes{room_}.subspan(room_in_front, taken.opened.size));
    if (!alert) return count(Refusal::malformed);
    if (*alert == Alert::warning) return;
    if (*alert == Alert::goodbye) say(*taken.entry, ContentType::alert, goodbye, via, out);
    close(*taken.entry);
}

/// At once.
void DtlsClients::say(Entry& entry, ContentType type, Bytes what, const Endpoint& via,
                      broker::Actions& out) {
    std::copy(what.begin(), what.end(), out.reserve(what.size()).begin());
    const auto size = static_cast<std::uint32_t>(what.size());
    // No node id: it is sealed already when the actions are.
    Send message{via, {entry.association.at(), {}}, 0, out.commit(size), size};
    if (seal_in_place(entry, type, message, 0, out)) out.push(std::move(message));
}

// --- out

void DtlsClients::seal(broker::Actions& actions) {
    for (broker::Action& action : actions.list()) {
        auto* send = std::get_if<Send>(&action);
        if (send == nullptr || !broker::is_dtls(send->via)) continue;
        const std::string_view id = broker::authenticated_id(send->via, send->to.wireless_node_id);
        if (id.empty()) continue;  // a handshake's, or an answer to SEARCHGW
        Entry* entry = association_with(id, {send->via, send->to.endpoint});
        if (entry == nullptr) {
            count(Refusal::no_association);
            send->via = {};
            continue;
        }
        const std::size_t header = actions.octets(*send)[0];
        if (!seal_in_place(*entry, ContentType::application_data, *send, header, actions)) {
            send->via = {};
        }
        send->to.endpoint = entry->association.at();
    }
}

DtlsClients::Entry* DtlsClients::association_with(std::string_view client_id, const Path& path) {
    const auto found = clients_.find(client_id);
    if (found == clients_.end()) return nullptr;
    const auto& entries = found->second->entries;
    const auto entry = std::ranges::find_if(entries, [&](const Entry* each) {
        const Association& with = each->association;
        return with.may_roam() ? with.path().from == path.from : with.path() == path;
    });
    return entry == entries.end() ? nullptr : *entry;
}

/// What `send` holds behind the first `skipped` octets becomes a record at the arena's end.
bool DtlsClients::seal_in_place(Entry& entry, ContentType type, Send& send, std::size_t skipped,
                                broker::Actions& actions) {
    const Turn before = entry.association.progress().turn;
    const MutableBytes out = actions.reserve(send.size + most_overhead);
    const auto size =
        entry.association.seal(cipher_, self_, type, actions.octets(send).subspan(skipped), out);
    if (entry.association.progress().turn != before) {
        note_to_tell(entry);
        has_news_ = true;
    }
    send.offset = actions.commit(size ? *size : 0);
    send.size = static_cast<std::uint32_t>(size ? *size : 0);
    if (!size) {
        count(size.error());
        return false;
    }
    ++counters_.sealed;
    return true;
}

// --- several brokers

Told DtlsClients::to_tell() {
    Told told;
    for (Entry* entry : to_tell_) {
        entry->is_to_tell = false;
        const Association& own = entry->association;
        if (std::exchange(entry->is_known_to_peers, true)) {
            told.progress.push_back({own.id(), own.progress()});
        } else {
            const Client& client = entry->client;
            told.associations.push_back({own.id(), client.id, own.path(),
                                         wrap(own.keys(), client.key, client.id, own.id()),
                                         own.progress(), own.roaming()});
        }
    }
    to_tell_.clear();
    told.progress.insert(told.progress.end(), closed_.begin(), closed_.end());
    closed_.clear();
    has_news_ = false;
    return told;
}

void DtlsClients::tell_all() {
    to_tell_.clear();
    for (const auto& [id, client] : clients_) {
        // Who hears it puts each in front of those before.
        for (auto entry = client->entries.rbegin(); entry != client->entries.rend(); ++entry) {
            (*entry)->is_known_to_peers = false;
            (*entry)->is_to_tell = true;
            to_tell_.push_back(*entry);
        }
    }
    has_news_ = has_news_ || !to_tell_.empty();
}

void DtlsClients::on_told(const Told& told) {
    for (const AssociationTold& each : told.associations) {
        const auto known = by_id_.find(static_cast<std::uint64_t>(each.id));
        if (known != by_id_.end()) {
            known->second->association.on_told(each.progress, each.roaming);
            continue;
        }
        const auto found = clients_.find(each.client_id);
        if (found == clients_.end()) continue;
        Client& client = *found->second;
        const auto keys = unwrap(each.keys, client.key, client.id, each.id);
        if (!keys) continue;
        put(client, Association{each.id, each.path, *keys, each.progress, self_, each.roaming})
            .is_known_to_peers = true;
    }
    for (const ProgressTold& each : told.progress) {
        const auto known = by_id_.find(static_cast<std::uint64_t>(each.id));
        if (known == by_id_.end()) continue;
        if (each.is_closed) {
            erase(*known->second);
        } else {
            known->second->association.on_told(each.progress);
        }
    }
}

}  // namespace romano::dtls
