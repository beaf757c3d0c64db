// Ends of DTLS 1.2 with a pre-shared key that are OpenSSL's alone, handshake and records: the peers
// that nobody here wrote. Without a Connection ID, which OpenSSL 3.0 does not know.
#pragma once

#include <openssl/err.h>
#include <openssl/ssl.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "romano/dtls/datagrams.h"
#include "romano/protection/keys.h"

namespace romano::dtls::openssl_ends {

class End : public Datagrams {
public:
    using Send = std::function<void(Bytes datagram)>;

    [[nodiscard]] bool is_connected() const {
        return ssl_ && !is_closed_ && SSL_is_init_finished(ssl_.get()) == 1;
    }
    [[nodiscard]] bool is_closed() const { return is_closed_; }

    [[nodiscard]] Bytes open(Bytes datagram) {
        set_input(datagram);
        if (!is_connected()) step();
        const Bytes message = is_connected() ? read() : Bytes{};
        set_input({});
        return message;
    }
    bool seal(Bytes message) {
        if (!is_connected()) return false;
        ERR_clear_error();
        return SSL_write(ssl_.get(), message.data(), static_cast<int>(message.size())) > 0;
    }
    /// Repeats what may be lost.
    void on_time() {
        ERR_clear_error();
        (void)DTLSv1_handle_timeout(ssl_.get());
    }
    void close() {
        (void)SSL_shutdown(ssl_.get());
        is_closed_ = true;
    }
    [[nodiscard]] SSL* ssl() { return ssl_.get(); }

protected:
    End(const SSL_METHOD* method, std::string identity, const protection::Key& key, Send send,
        const char* suites)
        : identity_(std::move(identity)),
          key_(key),
          send_(std::move(send)),
          context_(SSL_CTX_new(method)),
          room_(1U << 14U) {
        SSL_CTX_set_cipher_list(context_.get(), suites);
        SSL_CTX_set_options(context_.get(), SSL_OP_NO_TICKET | SSL_OP_NO_QUERY_MTU);
        SSL_CTX_set_psk_client_callback(context_.get(), on_hint);
        SSL_CTX_set_psk_server_callback(context_.get(), on_identity);
    }
    void begin() {
        ssl_ = make_ssl(context_.get());
        is_closed_ = false;
    }
    void step() {
        ERR_clear_error();
        const int done = SSL_do_handshake(ssl_.get());
        if (done != 1 && SSL_get_error(ssl_.get(), done) != SSL_ERROR_WANT_READ) is_closed_ = true;
    }

private:
    struct Free {
        void operator()(SSL_CTX* context) const { SSL_CTX_free(context); }
    };

    static End& of(SSL* ssl) { return static_cast<End&>(Datagrams::of(ssl)); }
    static unsigned int on_hint(SSL* ssl, const char*, char* identity, unsigned int,
                                unsigned char* key, unsigned int) {
        const std::string& own = of(ssl).identity_;
        *std::copy(own.begin(), own.end(), identity) = '\0';
        return copy_key(ssl, key);
    }
    static unsigned int on_identity(SSL* ssl, const char* identity, unsigned char* key,
                                    unsigned int) {
        return identity == of(ssl).identity_ ? copy_key(ssl, key) : 0;
    }
    static unsigned int copy_key(SSL* ssl, unsigned char* to) {
        const protection::Key& key = of(ssl).key_;
        std::copy(key.begin(), key.end(), to);
        return static_cast<unsigned int>(key.size());
    }

    void write(Bytes datagram) override { send_(datagram); }

    Bytes read() {
        ERR_clear_error();
        const int size = SSL_read(ssl_.get(), room_.data(), static_cast<int>(room_.size()));
        if (size > 0) return Bytes{room_}.first(static_cast<std::size_t>(size));
        if (SSL_get_error(ssl_.get(), size) != SSL_ERROR_WANT_READ) is_closed_ = true;
        return {};
    }

    std::string identity_;  // a server's: of its one client
    protection::Key key_;
    Send send_;
    std::unique_ptr<SSL_CTX, Free> context_;
    Ssl ssl_;
    std::vector<std::uint8_t> room_;
    bool is_closed_ = false;
};

struct Client final : End {
    Client(std::string identity, const protection::Key& key, Send send,
           const char* suites = "PSK-AES128-CCM8:PSK-AES128-GCM-SHA256")
        : End(DTLS_client_method(), std::move(identity), key, std::move(send), suites) {}
    void connect() {
        begin();
        SSL_set_connect_state(ssl());
        step();
    }
};

struct Server final : End {
    Server(std::string identity, const protection::Key& key, Send send, const char* suites)
        : End(DTLS_server_method(), std::move(identity), key, std::move(send), suites) {
        begin();
        SSL_set_accept_state(ssl());
    }
};

}  // namespace romano::dtls::openssl_ends
