// A broker's clients at DTLS addresses once their handshakes are done: opens their records for the
// broker core, seals what the core sends them, and goes on with what peers told of associations.
//
// To the core they look as protected clients do (broker/protection/protected_node.h). Nothing here
// grows with what strangers send: each client with a key has two associations at most, the one that
// it speaks by and the one before or after.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "broker/core/actions.h"
#include "broker/dtls/association.h"
#include "broker/dtls/refusal.h"
#include "broker/dtls/wrapped_keys.h"
#include "broker/protection/protected_clients.h"
#include "romano/base/bytes.h"
#include "romano/base/endpoint.h"
#include "romano/dtls/record/record_cipher.h"

namespace romano::dtls {

/// What a handshake leaves behind.
struct Agreed {
    std::string client_id;
    AssociationId id{};
    Path path;
    RecordKeys keys;
    std::optional<ConnectionId> clients_id{};  // of one that roams: what it wants to be sent
};

/// An association as brokers tell each other: once, and to newcomers.
struct AssociationTold {
    AssociationId id{};
    std::string client_id;
    Path path;
    WrappedKeys keys{};
    Progress progress;
    std::optional<Roaming> roaming{};
};
/// Of one that was told: each time before something leaves that depends on it.
struct ProgressTold {
    AssociationId id{};
    Progress progress;
    bool is_closed = false;
};
struct Told {
    std::vector<AssociationTold> associations;
    std::vector<ProgressTold> progress;

    [[nodiscard]] bool empty() const { return associations.empty() && progress.empty(); }
};

struct Counters {
    std::uint64_t opened = 0;
    std::uint64_t sealed = 0;
    std::uint64_t closed = 0;  // by an alert of the client
    std::uint64_t moved = 0;   // of clients, to other addresses
    Refusals refused;
};

/// For the core: where a client is, as the core knows it, and what it said.
struct Message {
    Path path;
    Bytes octets{};
};

class DtlsClients {
public:
    explicit DtlsClients(const Speaker& self);
    ~DtlsClients();

    /// These and no others; associations of clients whose keys are gone end.
    void set_clients(std::span<const broker::ProtectedClient> clients);
    [[nodiscard]] const protection::RobotKey* key_of(std::string_view client_id) const;

    void add(const Agreed& agreed);
    [[nodiscard]] std::size_t size() const { return by_id_.size(); }

    /// A record of epoch 1 with data or an alert, or with a Connection ID: what the core is to be
    /// given, valid until the next call; empty when there is nothing. Answers go to `out`, sealed.
    [[nodiscard]] Message open(const Path& path, const Record& record, broker::Actions& out);
    /// Seals all that leaves for these clients. What cannot be sealed has no `via` then.
    void seal(broker::Actions& actions);

    // --- several brokers
    /// There is what peers are to hear before anything else leaves: an association, the end of one,
    /// that its client moved, or that this broker began to speak.
    [[nodiscard]] bool has_news() const { return has_news_; }
    /// What is to be told since the last call.
    [[nodiscard]] Told to_tell();
    /// Everything is to be told once more: there are brokers that have not heard it.
    void tell_all();
    void on_told(const Told& told);

    void count(Refusal why) { counters_.refused.count(why); }
    [[nodiscard]] const Counters& counters() const { return counters_; }

private:
    struct Client;
    struct Entry;

    Entry& put(Client& client, Association&& association);
    void erase(Entry& entry);
    void note_to_tell(Entry& entry);
    struct Taken;

    [[nodiscard]] std::optional<Taken> take(const Path& path, const Record& record);
    [[nodiscard]] std::optional<Taken> take_by(Entry& entry, const Record& record, Refusal& why);
    void follow(const Taken& taken, const Path& path, std::size_t octets, broker::Actions& out);
    [[nodiscard]] Bytes take_message(const Taken& taken, const Path& path, broker::Actions& out);
    void take_alert(const Taken& taken, const Endpoint& via, broker::Actions& out);
    void say(Entry& entry, ContentType type, Bytes what, const Endpoint& via, broker::Actions& out);
    void close(Entry& entry);
    [[nodiscard]] Entry* association_with(std::string_view client_id, const Path& path);
    [[nodiscard]] bool seal_in_place(Entry& entry, ContentType type, broker::Send& send,
                                     std::size_t skipped, broker::Actions& actions);

    Speaker self_;
    RecordCipher cipher_;
    std::unordered_map<std::string_view, std::unique_ptr<Client>> clients_;  // views of their ids
    std::unordered_map<std::uint64_t, std::unique_ptr<Entry>> by_id_;
    std::unordered_multimap<Path, Entry*, PathHash> by_path_;  // of those that cannot roam
    std::vector<Entry*> to_tell_;
    std::vector<ProgressTold> closed_;
    bool has_news_ = false;
    std::vector<std::uint8_t> room_;
    Counters counters_;
};

}  // namespace romano::dtls
