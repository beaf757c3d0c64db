// Handshakes of DTLS 1.2 by OpenSSL: records in, records out, and in the end the keys of an
// association. A shell, for OpenSSL's timers read the real clock; no socket.
//
// A stranger costs nothing that stays before it has answered the cookie of its address (RFC 6347
// section 4.2.1), and then one of `most_handshakes` places for a while. Who came before has its
// place for `least_turn` at least, also when it has failed, so that no more than that many are
// begun in vain in that time, from one IP address `most_of_host`; after it the oldest makes room.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>

#include "broker/core/actions.h"
#include "broker/dtls/association.h"
#include "broker/dtls/cookie.h"
#include "broker/dtls/dtls_clients.h"
#include "romano/base/bytes.h"
#include "romano/base/time.h"
#include "romano/dtls/openssl_with_ids.h"
#include "romano/protection/keys.h"

struct ssl_ctx_st;
struct ssl_st;
struct x509_store_ctx_st;

namespace romano::dtls {

/// For clients that have certificates: the broker's own with its private key, and that of whom the
/// clients' are signed by. PEM.
struct Certificates {
    std::string own;
    std::string authority;
};

class Handshakes {
public:
    /// The key that a client with that identity has (RFC 4279); nothing for an unknown one, which
    /// then hears as little as one with a wrong key.
    using FindKey = std::function<std::optional<protection::Key>(std::string_view identity)>;

    /// `place` is the broker's. `secret` is drawn at random. Without certificates clients with
    /// pre-shared keys alone are served. Throws std::runtime_error with a sentence when they are
    /// none.
    Handshakes(std::uint32_t place, const protection::Key& secret, FindKey find_key,
               const std::optional<Certificates>& certificates);
    ~Handshakes();
    Handshakes(const Handshakes&) = delete;
    Handshakes& operator=(const Handshakes&) = delete;

    /// A record of a handshake. Its answers go to `out`; what it agreed on is returned once, before
    /// the answer that the client waits for has left.
    [[nodiscard]] std::optional<Agreed> take(Instant now, const Path& path, const Record& record,
                                             broker::Actions& out);
    /// A record with a Connection ID, without it, valid until the next call; nothing when it is of
    /// no handshake that goes on.
    [[nodiscard]] std::optional<Record> without_id(const Path& path, const Record& record);
    /// The client has spoken by what was agreed on: nothing needs to be repeated.
    void on_heard(const Path& path);
    /// About once a second: repeats what may be lost, and forgets what leads nowhere.
    void on_time(Instant now, broker::Actions& out);

    [[nodiscard]] std::size_t size() const { return going_on_.size(); }
    [[nodiscard]] std::uint64_t agreed() const { return agreed_; }
    [[nodiscard]] std::uint64_t failed() const { return failed_; }
    /// ClientHellos for which there was no room.
    [[nodiscard]] std::uint64_t crowded_out() const { return crowded_out_; }

    static constexpr std::size_t most_handshakes = 256;
    static constexpr std::size_t most_of_host = 64;
    static constexpr Duration least_turn = std::chrono::seconds{1};

private:
    struct Handshake;
    struct FreeContext {
        void operator()(ssl_ctx_st* context) const;
    };

    [[nodiscard]] std::optional<Agreed> begin(Instant now, const Path& path, const Record& record,
                                              const ClientHello& hello, broker::Actions& out);
    [[nodiscard]] std::optional<Agreed> step(Handshake& handshake, Bytes record,
                                             broker::Actions& out);
    [[nodiscard]] static std::optional<Agreed> agreement(const Handshake& handshake);
    using GoingOn = std::unordered_map<Path, std::unique_ptr<Handshake>, PathHash>;

    /// For a new one from there; false when nobody can make way.
    [[nodiscard]] bool make_room(Instant now, const Path& path);
    void drop(GoingOn::iterator handshake);
    void fail(Handshake& handshake);

    static int on_cookie(ssl_st* ssl, const unsigned char* cookie, unsigned int size);
    void use(const Certificates& certificates);
    static int on_certificate(int is_signed, x509_store_ctx_st* about);
    static unsigned int on_identity(ssl_st* ssl, const char* identity, unsigned char* key,
                                    unsigned int most);

    std::uint32_t place_;
    protection::Key secret_;
    protection::Key cookie_key_{};
    OpensslWithIds ids_{End::server};
    FindKey find_key_;
    std::unique_ptr<ssl_ctx_st, FreeContext> context_;
    GoingOn going_on_;
    std::uint64_t agreed_ = 0;
    std::uint64_t failed_ = 0;
    std::uint64_t crowded_out_ = 0;
};

}  // namespace romano::dtls
