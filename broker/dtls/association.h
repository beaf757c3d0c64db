// One client's association with the brokers of a cluster (RFC 6347), as any of them keeps it: keys,
// which of the client's records were there, and whose turn it is to number records to the client.
// No more than that, so that it can be told to peers and every session can have one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>

#include "broker/dtls/refusal.h"
#include "broker/dtls/turn.h"
#include "romano/base/bytes.h"
#include "romano/base/endpoint.h"
#include "romano/base/result.h"
#include "romano/dtls/record/connection_id.h"
#include "romano/dtls/record/record.h"
#include "romano/dtls/record/record_cipher.h"
#include "romano/protection/replay_window.h"
#include "romano/protection/reserve.h"

namespace romano::dtls {

/// Between a client's address and a service address.
struct Path {
    Endpoint via;
    Endpoint from;

    friend bool operator==(const Path&, const Path&) = default;
};
struct PathHash {
    std::size_t operator()(const Path& path) const {
        return path.from.hash() ^ path.via.hash() * 0x9E3779B97F4A7C15ULL;
    }
};

/// Octets of the handshake's key expansion that are no keys; of a client that roams, the Connection
/// ID that its broker chose (own_id.h). Nobody has the same by accident.
enum class AssociationId : std::uint64_t {};

/// How far both directions are, for whoever goes on in another's place.
struct Progress {
    Turn turn;                // the latest
    std::uint64_t floor = 0;  // the client's records below are old

    friend bool operator==(const Progress&, const Progress&) = default;
};

/// A broker as a sender of records. The reserve is stored beside the place.
struct Speaker {
    std::uint32_t place;  // 1 to most_places; 0: it may not speak
    protection::Reserve& reserve;
};

/// Of a client that may change its address.
struct Roaming {
    ConnectionId id;  // the client's own: in front of what it is sent
    Endpoint at;      // where it is, as far as its newest record says

    friend bool operator==(const Roaming&, const Roaming&) = default;
};

class Association {
public:
    /// Of a handshake that this broker made.
    Association(AssociationId id, const Path& path, const RecordKeys& keys,
                const std::optional<ConnectionId>& clients_id = std::nullopt);
    /// Of another's, or an earlier one of this.
    Association(AssociationId id, const Path& path, const RecordKeys& keys, const Progress& told,
                const Speaker& self, const std::optional<Roaming>& roaming = std::nullopt);

    [[nodiscard]] Result<Opened, Refusal> open(RecordCipher& cipher, const Record& record,
                                               MutableBytes out);
    /// The size of the record in `out`.
    [[nodiscard]] Result<std::size_t, Refusal> seal(RecordCipher& cipher, const Speaker& self,
                                                    ContentType type, Bytes message,
                                                    MutableBytes out);

    // --- roaming (README.md, "A client that changes its address")
    /// A record came from there, was opened, and none was newer. True when the client was
    /// elsewhere.
    bool on_newest_from(const Endpoint& at, std::size_t octets);
    /// It has answered what was sent to where it is.
    void on_answered() { allowance_ = unlimited; }
    [[nodiscard]] bool has_answered() const { return allowance_ == unlimited; }
    [[nodiscard]] bool may_roam() const { return may_roam_; }
    [[nodiscard]] std::optional<Roaming> roaming() const {
        return may_roam_ ? std::optional{Roaming{clients_id_, at_}} : std::nullopt;
    }
    /// Where its records go.
    [[nodiscard]] const Endpoint& at() const { return at_; }

    [[nodiscard]] Progress progress() const { return {turn_, window_.end()}; }
    [[nodiscard]] bool is_newest(std::uint64_t number) const { return window_.is_newest(number); }
    /// A peer says how far it is. True when that is news.
    bool on_told(const Progress& told);
    /// And where the client is: who has its newest record knows it.
    void on_told(const Progress& told, const std::optional<Roaming>& roaming);

    [[nodiscard]] AssociationId id() const { return id_; }
    /// Where the handshake was made: to the core this is where the client is, for good.
    [[nodiscard]] const Path& path() const { return path_; }
    [[nodiscard]] const RecordKeys& keys() const { return keys_; }

private:
    static constexpr std::uint32_t unlimited = std::numeric_limits<std::uint32_t>::max();

    RecordKeys keys_;
    Path path_;
    Endpoint at_;
    AssociationId id_;
    ConnectionId clients_id_;
    bool may_roam_ = false;
    protection::WindowOf<std::uint64_t> window_;
    Turn turn_;
    std::uint32_t count_ = 0;              // this broker's next
    std::uint32_t allowance_ = unlimited;  // octets that may be sent before an answer
    bool is_own_turn_ = false;
    bool is_first_ = false;  // none of the client's was opened here, and there were some before
};

// What a session costs beside itself.
static_assert(sizeof(Association) <= 200);

}  // namespace romano::dtls
