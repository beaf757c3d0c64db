// Datagrams for OpenSSL, without sockets: it reads the one that is there, and writes to its owner.
// A memory BIO does not keep datagrams apart.
#pragma once

#include <openssl/bio.h>
#include <openssl/ssl.h>

#include <memory>

#include "romano/base/bytes.h"

namespace romano::dtls {

class Datagrams {
public:
    /// Fits IPv6's smallest MTU.
    static constexpr long mtu = 1'232;

    virtual ~Datagrams() = default;
    Datagrams(const Datagrams&) = delete;
    Datagrams& operator=(const Datagrams&) = delete;

    struct FreeSsl {
        void operator()(SSL* ssl) const { SSL_free(ssl); }
    };
    using Ssl = std::unique_ptr<SSL, FreeSsl>;

    /// One that reads and writes here, neither client nor server yet. This outlives it.
    [[nodiscard]] Ssl make_ssl(SSL_CTX* context);
    /// Where it reads and writes.
    [[nodiscard]] static Datagrams& of(const SSL* ssl) {
        return *static_cast<Datagrams*>(SSL_get_app_data(ssl));
    }

    /// What is to be read, once; it lives until then.
    void set_input(Bytes datagram) { in_ = datagram; }

protected:
    Datagrams() = default;

private:
    virtual void write(Bytes datagram) = 0;

    struct Method;

    Bytes in_;
};

}  // namespace romano::dtls
