#include "romano/dtls/client_handshake.h"

#include <openssl/err.h>
#include <openssl/ssl.h>
#include <sys/time.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <stdexcept>
#include <utility>

#include "romano/dtls/datagrams.h"
#include "romano/dtls/openssl_with_ids.h"
#include "romano/dtls/record/client_records.h"

namespace romano::dtls {
namespace {

// It wants to be sent records without an id.
constexpr std::array<std::uint8_t, 1> no_own_id{0};

}  // namespace

struct ClientHandshake::Openssl final : Datagrams {
    struct Free {
        void operator()(SSL_CTX* context) const { SSL_CTX_free(context); }
    };

    Openssl(std::string name, const protection::Key& psk, Send sender, const char* suites,
            Wants wants)
        : identity(std::move(name)),
          key(psk),
          send(std::move(sender)),
          context(SSL_CTX_new(DTLS_client_method())) {
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
        auto& self = static_cast<Openssl&>(of(ssl));
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
        const auto& self = static_cast<const Openssl&>(of(ssl));
        if (self.identity.size() >= most_identity || self.key.size() > most_key) return 0;
        *std::copy(self.identity.begin(), self.identity.end(), identity) = '\0';
        std::copy(self.key.begin(), self.key.end(), key);
        return static_cast<unsigned int>(self.key.size());
    }

    void write(Bytes datagram) override {
        first_number = std::max(first_number, number_above(datagram));
        if (!brokers_id.empty()) {
            if (!keys) keys = session_keys(ssl.get());
            datagram = ids.with_id(keys, datagram, brokers_id);
        }
        if (!datagram.empty()) send(datagram);
    }

    void begin() {
        ssl = make_ssl(context.get());
        SSL_set_connect_state(ssl.get());
        brokers_id = {};
        keys.reset();
        first_number = 0;
    }

    std::optional<Agreed> step(Bytes record) {
        set_input(record);
        ERR_clear_error();
        const int done = SSL_do_handshake(ssl.get());
        const bool waits = done != 1 && SSL_get_error(ssl.get(), done) == SSL_ERROR_WANT_READ;
        set_input({});
        if (waits) return std::nullopt;
        if (done == 1 && !keys) keys = session_keys(ssl.get());
        ssl.reset();
        if (done != 1 || !keys) return std::nullopt;
        return Agreed{std::exchange(keys, std::nullopt)->keys, brokers_id, first_number};
    }

    std::string identity;
    protection::Key key;
    Send send;
    OpensslWithIds ids{End::client};
    ConnectionId brokers_id;
    std::optional<SessionKeys> keys;  // once a record takes them: it is long to derive them
    std::uint64_t first_number = 0;
    std::unique_ptr<SSL_CTX, Free> context;
    Ssl ssl;  // while a handshake goes on
};

ClientHandshake::ClientHandshake(std::string identity, const protection::Key& key, Send send,
                                 const char* suites, Wants wants)
    : openssl_(
          std::make_unique<Openssl>(std::move(identity), key, std::move(send), suites, wants)) {}
ClientHandshake::~ClientHandshake() = default;

void ClientHandshake::begin() {
    openssl_->begin();
    (void)openssl_->step({});
}

void ClientHandshake::give_up() {
    openssl_->ssl.reset();
}

bool ClientHandshake::goes_on() const {
    return openssl_->ssl != nullptr;
}

std::optional<ClientHandshake::Agreed> ClientHandshake::take(Bytes record) {
    return goes_on() ? openssl_->step(record) : std::nullopt;
}

std::optional<Duration> ClientHandshake::due_in() const {
    timeval left{};
    if (!goes_on() || DTLSv1_get_timeout(openssl_->ssl.get(), &left) != 1) return std::nullopt;
    return std::chrono::seconds{left.tv_sec} + std::chrono::microseconds{left.tv_usec};
}

void ClientHandshake::on_time() {
    if (!goes_on()) return;
    ERR_clear_error();
    if (DTLSv1_handle_timeout(openssl_->ssl.get()) < 0) give_up();
}

}  // namespace romano::dtls
