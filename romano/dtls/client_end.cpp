#include "romano/dtls/client_end.h"

#include <openssl/err.h>
#include <openssl/ssl.h>
#include <sys/time.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <new>
#include <stdexcept>
#include <utility>

#include "romano/dtls/datagrams.h"
#include "romano/dtls/openssl_with_ids.h"

namespace romano::dtls {
namespace {

// It wants to be sent records without an id.
constexpr std::array<std::uint8_t, 1> no_own_id{0};

}  // namespace

struct ClientEnd::Session final : Datagrams {
    struct Free {
        void operator()(SSL_CTX* context) const { SSL_CTX_free(context); }
        void operator()(SSL* of_it) const { SSL_free(of_it); }
    };

    Session(std::string name, const protection::Key& psk, Send sender, const char* suites,
            Wants wants)
        : identity(std::move(name)),
          key(psk),
          send(std::move(sender)),
          context(SSL_CTX_new(DTLS_client_method())),
          room(most_message) {
        if (!context || SSL_CTX_set_min_proto_version(context.get(), DTLS1_2_VERSION) != 1 ||
            SSL_CTX_set_cipher_list(context.get(), suites) != 1) {
            throw std::runtime_error("OpenSSL has no DTLS 1.2 with " + std::string{suites});
        }
        SSL_CTX_set_options(context.get(), SSL_OP_NO_TICKET | SSL_OP_NO_QUERY_MTU);
        SSL_CTX_set_psk_client_callback(context.get(), on_hint);
        if (wants == Wants::none) return;
        if (SSL_CTX_add_custom_ext(context.get(), connection_id_extension,
                                   SSL_EXT_CLIENT_HELLO | SSL_EXT_TLS1_2_SERVER_HELLO, on_offer,
                                   nullptr, nullptr, on_answer, nullptr) != 1) {
            throw std::runtime_error("OpenSSL does not let us have Connection IDs");
        }
    }

    static int on_offer(SSL*, unsigned int, unsigned int, const unsigned char** body,
                        std::size_t* size, X509*, std::size_t, int*, void*) {
        *body = no_own_id.data();
        *size = no_own_id.size();
        return 1;
    }
    static int on_answer(SSL* ssl, unsigned int, unsigned int, const unsigned char* body,
                         std::size_t size, X509*, std::size_t, int* alert, void*) {
        auto& self = *static_cast<Session*>(SSL_get_app_data(ssl));
        bool is_malformed = false;
        const auto id = id_in_extension({body, size}, is_malformed);
        if (!id) {
            *alert = is_malformed ? SSL_AD_DECODE_ERROR : SSL_AD_ILLEGAL_PARAMETER;
            return 0;
        }
        self.brokers_id = *id;
        return 1;
    }

    static unsigned int on_hint(SSL* ssl, const char*, char* identity, unsigned int most_identity,
                                unsigned char* key, unsigned int most_key) {
        const auto& self = *static_cast<const Session*>(SSL_get_app_data(ssl));
        if (self.identity.size() >= most_identity || self.key.size() > most_key) return 0;
        *std::copy(self.identity.begin(), self.identity.end(), identity) = '\0';
        std::copy(self.key.begin(), self.key.end(), key);
        return static_cast<unsigned int>(self.key.size());
    }

    void write(Bytes datagram) override {
        if (!brokers_id.empty()) {
            if (!keys) keys = session_keys(ssl.get());
            datagram = ids.with_id(keys, datagram, brokers_id);
        }
        if (!datagram.empty()) send(datagram);
    }

    void step() {
        ERR_clear_error();
        const int done = SSL_do_handshake(ssl.get());
        if (done != 1 && SSL_get_error(ssl.get(), done) != SSL_ERROR_WANT_READ) is_closed = true;
    }

    std::string identity;
    protection::Key key;
    Send send;
    OpensslWithIds ids{End::client};
    ConnectionId brokers_id;          // empty: it gave none
    std::optional<SessionKeys> keys;  // once a record takes them: it is long to derive them
    std::unique_ptr<SSL_CTX, Free> context;
    std::unique_ptr<SSL, Free> ssl;
    std::vector<std::uint8_t> room;
    bool is_closed = false;
};

ClientEnd::ClientEnd(std::string identity, const protection::Key& key, Send send,
                     const char* suites, Wants wants)
    : session_(
          std::make_unique<Session>(std::move(identity), key, std::move(send), suites, wants)) {}
ClientEnd::~ClientEnd() = default;

void ClientEnd::connect() {
    Session& session = *session_;
    session.ssl.reset(SSL_new(session.context.get()));
    if (!session.ssl) throw std::bad_alloc();
    BIO* bio = session.bio();
    SSL_set_bio(session.ssl.get(), bio, bio);
    SSL_set_app_data(session.ssl.get(), &session);
    SSL_set_mtu(session.ssl.get(), Datagrams::mtu);
    SSL_set_connect_state(session.ssl.get());
    session.is_closed = false;
    session.brokers_id = {};
    session.keys.reset();
    session.step();
}

bool ClientEnd::is_connected() const {
    return session_->ssl && !session_->is_closed && SSL_is_init_finished(session_->ssl.get()) == 1;
}

bool ClientEnd::is_closed() const {
    return session_->is_closed;
}

bool ClientEnd::may_roam() const {
    return is_connected() && !session_->brokers_id.empty();
}

Bytes ClientEnd::open(Bytes datagram) {
    Session& session = *session_;
    if (!session.ssl || session.is_closed) return {};
    session.set_input(datagram);
    if (!is_connected()) session.step();
    Bytes message;
    if (is_connected()) {
        ERR_clear_error();
        const int size =
            SSL_read(session.ssl.get(), session.room.data(), static_cast<int>(session.room.size()));
        if (size > 0) {
            message = Bytes{session.room}.first(static_cast<std::size_t>(size));
        } else if (SSL_get_error(session.ssl.get(), size) != SSL_ERROR_WANT_READ) {
            session.is_closed = true;
        }
    }
    session.set_input({});
    return message;
}

bool ClientEnd::seal(Bytes message) {
    if (!is_connected()) return false;
    ERR_clear_error();
    return SSL_write(session_->ssl.get(), message.data(), static_cast<int>(message.size())) > 0;
}

std::optional<Duration> ClientEnd::due_in() const {
    if (!session_->ssl || session_->is_closed || is_connected()) return std::nullopt;
    timeval left{};
    if (DTLSv1_get_timeout(session_->ssl.get(), &left) != 1) return std::nullopt;
    return std::chrono::seconds{left.tv_sec} + std::chrono::microseconds{left.tv_usec};
}

void ClientEnd::on_time() {
    if (!session_->ssl || session_->is_closed || is_connected()) return;
    ERR_clear_error();
    if (DTLSv1_handle_timeout(session_->ssl.get()) < 0) session_->is_closed = true;
}

void ClientEnd::close() {
    if (is_connected()) (void)SSL_shutdown(session_->ssl.get());
    session_->is_closed = true;
}

}  // namespace romano::dtls
