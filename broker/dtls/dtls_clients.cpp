#include "broker/dtls/dtls_clients.h"

#include <algorithm>
#include <utility>

#include "broker/protection/client_names.h"
#include "broker/protection/protected_node.h"
#include "romano/mqttsn/decode.h"

namespace romano::dtls {

using broker::Send;
using mqttsn::MsgType;

namespace {

constexpr std::size_t most_associations = 2;  // of a client
// In front of a message there is room for the header of its forwarder.
constexpr std::size_t room_in_front = 256;

// RFC 5246 section 7.2.
constexpr std::uint8_t warning = 1;
constexpr std::uint8_t fatal = 2;
constexpr std::uint8_t close_notify = 0;
constexpr std::size_t alert_octets = 2;

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

DtlsClients::DtlsClients(const Speaker& self) : self_(self), room_(room_in_front + most_message) {}
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
    note_to_tell(put(client, Association{agreed.id, agreed.path, agreed.keys}));
    has_news_ = true;
}

DtlsClients::Entry& DtlsClients::put(Client& client, Association&& association) {
    const auto id = static_cast<std::uint64_t>(association.id());
    if (const auto same = by_id_.find(id); same != by_id_.end()) erase(*same->second);
    if (client.entries.size() == most_associations) erase(*client.entries.back());
    auto entry = std::make_unique<Entry>(client, std::move(association));
    Entry& there = *entry;
    client.entries.insert(client.entries.begin(), &there);
    by_path_.emplace(there.association.path(), &there);
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

Bytes DtlsClients::open(const Path& path, const Record& record, broker::Actions& out) {
    std::size_t size = 0;
    Entry* entry = opener_of(path, record, size);
    if (entry == nullptr) return {};
    ++counters_.opened;
    note_to_tell(*entry);
    auto& entries = entry->client.entries;
    if (entries.front() != entry) std::swap(entries.front(), entries.back());
    if (record.type == ContentType::application_data) return take_message(*entry, size, out);
    take_alert(*entry, size, out);
    return {};
}

/// Clients behind one address, and a client that began anew from where it was, share a path.
DtlsClients::Entry* DtlsClients::opener_of(const Path& path, const Record& record,
                                           std::size_t& size) {
    auto why = Refusal::unknown_sender;
    const auto [begin, end] = by_path_.equal_range(path);
    for (auto each = begin; each != end; ++each) {
        const auto opened = each->second->association.open(
            cipher_, record, MutableBytes{room_}.subspan(room_in_front));
        if (opened) {
            size = *opened;
            return each->second;
        }
        why = opened.error();
    }
    count(why);
    return nullptr;
}

Bytes DtlsClients::take_message(Entry& entry, std::size_t size, broker::Actions& out) {
    const Client& client = entry.client;
    const Bytes message = Bytes{room_}.subspan(room_in_front, size);
    const auto frame = mqttsn::decode_frame(message);
    if (frame && frame->type == MsgType::encapsulated) {
        count(Refusal::forwarded);
        return {};
    }
    const Path& path = entry.association.path();
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

/// RFC 5246 section 7.2.1: close_notify is answered by the same.
void DtlsClients::take_alert(Entry& entry, std::size_t size, broker::Actions& out) {
    if (size != alert_octets) return count(Refusal::malformed);
    const std::uint8_t level = room_[room_in_front];
    const bool closes = room_[room_in_front + 1] == close_notify;
    if (!closes && level != fatal) return;
    if (closes) {
        const MutableBytes octets = out.reserve(alert_octets);
        octets[0] = warning;
        octets[1] = close_notify;
        const Path path = entry.association.path();
        // No node id: it is sealed already when the actions are.
        Send answer{path.via, {path.from, {}}, 0, out.commit(alert_octets), alert_octets};
        if (seal_in_place(entry, ContentType::alert, answer, 0, out)) out.push(std::move(answer));
    }
    close(entry);
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
    }
}

DtlsClients::Entry* DtlsClients::association_with(std::string_view client_id, const Path& path) {
    const auto found = clients_.find(client_id);
    if (found == clients_.end()) return nullptr;
    const auto& entries = found->second->entries;
    const auto entry = std::ranges::find_if(
        entries, [&](const Entry* each) { return each->association.path() == path; });
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
                                         own.progress()});
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
            known->second->association.on_told(each.progress);
            continue;
        }
        const auto found = clients_.find(each.client_id);
        if (found == clients_.end()) continue;
        Client& client = *found->second;
        const auto keys = unwrap(each.keys, client.key, client.id, each.id);
        if (!keys) continue;
        put(client, Association{each.id, each.path, *keys, each.progress, self_})
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
