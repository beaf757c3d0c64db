// One client's association with the brokers of a cluster (RFC 6347), as any of them keeps it: keys,
// which of the client's records were there, and whose turn it is to number records to the client.
// No more than that, so that it can be told to peers and every session can have one.
#pragma once

#include <cstddef>
#include <cstdint>

#include "broker/dtls/record.h"
#include "broker/dtls/record_cipher.h"
#include "broker/dtls/refusal.h"
#include "broker/dtls/turn.h"
#include "romano/base/bytes.h"
#include "romano/base/endpoint.h"
#include "romano/base/result.h"
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

/// Octets of the handshake's key expansion that are no keys: nobody has the same by accident.
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

class Association {
public:
    /// Of a handshake that this broker made.
    Association(AssociationId id, const Path& path, const RecordKeys& keys)
        : keys_(keys), path_(path), id_(id) {}
    /// Of another's, or an earlier one of this.
    Association(AssociationId id, const Path& path, const RecordKeys& keys, const Progress& told,
                const Speaker& self);

    /// The size of the message in `out`.
    [[nodiscard]] Result<std::size_t, Refusal> open(RecordCipher& cipher, const Record& record,
                                                    MutableBytes out);
    /// The size of the record in `out`.
    [[nodiscard]] Result<std::size_t, Refusal> seal(RecordCipher& cipher, const Speaker& self,
                                                    ContentType type, Bytes message,
                                                    MutableBytes out);

    [[nodiscard]] Progress progress() const { return {turn_, window_.end()}; }
    /// A peer says how far it is. True when that is news.
    bool on_told(const Progress& told);

    [[nodiscard]] AssociationId id() const { return id_; }
    [[nodiscard]] const Path& path() const { return path_; }
    [[nodiscard]] const RecordKeys& keys() const { return keys_; }

private:
    RecordKeys keys_;
    Path path_;
    AssociationId id_;
    protection::WindowOf<std::uint64_t> window_;
    Turn turn_;
    std::uint32_t count_ = 0;  // this broker's next
    bool is_own_turn_ = false;
    bool is_first_ = false;  // none of the client's was opened here, and there were some before
};

// What a session costs beside itself.
static_assert(sizeof(Association) <= 200);

}  // namespace romano::dtls
