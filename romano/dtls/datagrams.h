// Datagrams for OpenSSL, without sockets: it reads the one that is there, and writes to its owner.
// A memory BIO does not keep datagrams apart.
#pragma once

#include <openssl/bio.h>

#include "romano/base/bytes.h"

namespace romano::dtls {

class Datagrams {
public:
    /// Fits IPv6's smallest MTU.
    static constexpr long mtu = 1'232;

    virtual ~Datagrams() = default;
    Datagrams(const Datagrams&) = delete;
    Datagrams& operator=(const Datagrams&) = delete;

    /// To be given to SSL_set_bio(), and freed by that; this outlives it.
    [[nodiscard]] BIO* bio();

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
