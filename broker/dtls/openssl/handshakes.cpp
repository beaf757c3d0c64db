#include "broker/dtls/openssl/handshakes.h"

#include <openssl/crypto.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/rand.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <new>
#include <stdexcept>
#include <utility>

#include "broker/dtls/own_id.h"
#include "romano/dtls/datagrams.h"
#include "romano/dtls/session_keys.h"

namespace romano::dtls {

using namespace std::chrono_literals;
using broker::Actions;
using broker::Send;

namespace {

// A client repeats what was lost after 1, 2, 4 s.
constexpr auto patience = 15s;

constexpr const char* psk_suites = "PSK-AES128-CCM8:PSK-AES128-GCM-SHA256";
// RFC 7251 and RFC 5289.
constexpr const char* all_suites =
    "PSK-AES128-CCM8:PSK-AES128-GCM-SHA256:ECDHE-ECDSA-AES128-CCM8:ECDHE-ECDSA-AES128-GCM-SHA256";

struct FreeCertificate {
    void operator()(BIO* bio) const { BIO_free(bio); }
    void operator()(X509* certificate) const { X509_free(certificate); }
    void operator()(EVP_PKEY* key) const { EVP_PKEY_free(key); }
};

std::unique_ptr<BIO, FreeCertificate> reader_of(const std::string& text) {
    return std::unique_ptr<BIO, FreeCertificate>{
        BIO_new_mem_buf(text.data(), static_cast<int>(text.size()))};
}

bool is_same(const Cookie& own, Bytes said) {
    return said.size() == own.size() && CRYPTO_memcmp(said.data(), own.data(), own.size()) == 0;
}

/// The octets that were written to what `out` had reserved.
void send(const Path& path, std::size_t octets, Actions& out) {
    const auto size = static_cast<std::uint32_t>(octets);
    out.push(Send{path.via, {path.from, {}}, 0, out.commit(octets), size});
}

/// The common name; empty when there is none, or one that is too long for a client id.
std::string name_in(X509* certificate) {
    std::array<char, 64> text{};
    const int size = X509_NAME_get_text_by_NID(X509_get_subject_name(certificate), NID_commonName,
                                               text.data(), static_cast<int>(text.size()));
    return size > 0 ? std::string(text.data(), static_cast<std::size_t>(size)) : std::string{};
}

}  // namespace

struct Handshakes::Handshake final : Datagrams {
    Handshake(Handshakes& whose, SSL_CTX* context) : owner(whose), ssl(make_ssl(context)) {
        SSL_set_accept_state(ssl.get());
    }
    static Handshake& of(const SSL* ssl) { return static_cast<Handshake&>(Datagrams::of(ssl)); }

    void write(Bytes datagram) override {
        if (clients_id && !clients_id->empty()) {
            datagram = owner.ids_.with_id(session_keys(ssl.get()), datagram, *clients_id);
            if (datagram.empty()) return;
        }
        std::ranges::copy(datagram, out->reserve(datagram.size()).begin());
        send(path, datagram.size(), *out);
    }

    // --- Connection IDs: OpenSSL asks
    /// Of a ClientHello.
    static int on_offer(SSL* ssl, unsigned int, unsigned int, const unsigned char* body,
                        std::size_t size, X509*, std::size_t, int* alert, void*) {
        bool is_malformed = false;
        Handshake::of(ssl).clients_id = id_in_extension({body, size}, is_malformed);
        if (is_malformed) *alert = SSL_AD_DECODE_ERROR;
        return is_malformed ? 0 : 1;
    }
    /// Of the ServerHello, where the client offered.
    static int on_answer(SSL* ssl, unsigned int, unsigned int, const unsigned char** body,
                         std::size_t* size, X509*, std::size_t, int*, void*) {
        Handshake& handshake = Handshake::of(ssl);
        auto& answer = handshake.id_answer;
        if (!handshake.clients_id || RAND_bytes(answer.data(), own_id_octets) != 1) return 0;
        const AssociationId drawn = own_id_of(Bytes{answer}.first(own_id_octets));
        handshake.id = own_id(handshake.owner.place_, static_cast<std::uint64_t>(drawn));
        answer[0] = own_id_octets;
        put_be64(answer, 1, static_cast<std::uint64_t>(handshake.id));
        *body = answer.data();
        *size = answer.size();
        return 1;
    }

    /// It keeps its place for its turn, so that nobody begins as often as it can fail.
    [[nodiscard]] bool has_failed() const { return ssl == nullptr; }

    Handshakes& owner;
    Path path;
    Actions* out = nullptr;  // while OpenSSL works
    std::string identity;    // that has a key
    Instant began;
    std::array<std::uint8_t, 32> client_random{};
    std::optional<ConnectionId> clients_id;  // when both have agreed on such ids
    AssociationId id{};                      // and the one that we gave
    std::array<std::uint8_t, 1 + own_id_octets> id_answer{};
    bool is_agreed = false;
    Ssl ssl;  // gone before what it writes to
};

void Handshakes::FreeContext::operator()(ssl_ctx_st* context) const {
    SSL_CTX_free(context);
}

Handshakes::Handshakes(std::uint32_t place, const protection::Key& secret, FindKey find_key,
                       const std::optional<Certificates>& certificates)
    : place_(place),
      secret_(secret),
      find_key_(std::move(find_key)),
      context_(SSL_CTX_new(DTLS_server_method())) {
    protection::hkdf_sha256(secret, {}, "ROMANO DTLS cookie", {}, cookie_key_);
    SSL_CTX* context = context_.get();
    if (context == nullptr || SSL_CTX_set_min_proto_version(context, DTLS1_2_VERSION) != 1 ||
        SSL_CTX_set_cipher_list(context, certificates ? all_suites : psk_suites) != 1) {
        throw std::runtime_error("OpenSSL has no DTLS 1.2 with AES-128-CCM-8 and pre-shared keys");
    }
    // A client that offers both has a pre-shared key, and perhaps no certificate: our order counts.
    SSL_CTX_set_options(context, SSL_OP_NO_TICKET | SSL_OP_NO_RENEGOTIATION | SSL_OP_NO_QUERY_MTU |
                                     SSL_OP_COOKIE_EXCHANGE | SSL_OP_NO_COMPRESSION |
                                     SSL_OP_CIPHER_SERVER_PREFERENCE);
    SSL_CTX_set_session_cache_mode(context, SSL_SESS_CACHE_OFF);
    SSL_CTX_set_mode(context, SSL_MODE_RELEASE_BUFFERS);
    SSL_CTX_set_cookie_verify_cb(context, on_cookie);
    SSL_CTX_set_psk_server_callback(context, on_identity);
    if (SSL_CTX_add_custom_ext(
            context, connection_id_extension, SSL_EXT_CLIENT_HELLO | SSL_EXT_TLS1_2_SERVER_HELLO,
            Handshake::on_answer, nullptr, nullptr, Handshake::on_offer, nullptr) != 1) {
        throw std::runtime_error("OpenSSL does not let us have Connection IDs");
    }
    if (certificates) use(*certificates);
}
Handshakes::~Handshakes() = default;

// --- what OpenSSL asks

/// OpenSSL asks again what begin() asked.
int Handshakes::on_cookie(ssl_st* ssl, const unsigned char* cookie, unsigned int size) {
    const Handshake& handshake = Handshake::of(ssl);
    const Cookie own = cookie_of(handshake.owner.cookie_key_, handshake.path);
    return is_same(own, {cookie, size}) ? 1 : 0;
}

void Handshakes::use(const Certificates& certificates) {
    SSL_CTX* context = context_.get();
    const std::unique_ptr<X509, FreeCertificate> own{
        PEM_read_bio_X509(reader_of(certificates.own).get(), nullptr, nullptr, nullptr)};
    const std::unique_ptr<EVP_PKEY, FreeCertificate> key{
        PEM_read_bio_PrivateKey(reader_of(certificates.own).get(), nullptr, nullptr, nullptr)};
    const std::unique_ptr<X509, FreeCertificate> authority{
        PEM_read_bio_X509(reader_of(certificates.authority).get(), nullptr, nullptr, nullptr)};
    if (!authority) throw std::runtime_error("the authority's certificate is none");
    if (!own || !key || SSL_CTX_use_certificate(context, own.get()) != 1 ||
        SSL_CTX_use_PrivateKey(context, key.get()) != 1) {
        throw std::runtime_error("the broker's certificate is none, or its private key another's");
    }
    if (X509_STORE_add_cert(SSL_CTX_get_cert_store(context), authority.get()) != 1) {
        throw std::bad_alloc();
    }
    // A certificate is asked for by the suites of certificates alone.
    SSL_CTX_set_verify(context, SSL_VERIFY_PEER | SSL_VERIFY_FAIL_IF_NO_PEER_CERT, on_certificate);
    SSL_CTX_set_verify_depth(context, 1);
}

/// Who has a certificate needs a key in the table, too: it says who may what, and is withdrawn
/// there.
int Handshakes::on_certificate(int is_signed, x509_store_ctx_st* about) {
    if (is_signed != 1 || X509_STORE_CTX_get_error_depth(about) != 0) return is_signed;
    auto* ssl =
        static_cast<SSL*>(X509_STORE_CTX_get_ex_data(about, SSL_get_ex_data_X509_STORE_CTX_idx()));
    Handshake& handshake = Handshake::of(ssl);
    std::string name = name_in(X509_STORE_CTX_get_current_cert(about));
    if (!handshake.owner.find_key_(name)) {
        X509_STORE_CTX_set_error(about, X509_V_ERR_CERT_REVOKED);
        return 0;
    }
    handshake.identity = std::move(name);
    return 1;
}

unsigned int Handshakes::on_identity(ssl_st* ssl, const char* identity, unsigned char* key,
                                     unsigned int most) {
    Handshake& handshake = Handshake::of(ssl);
    if (identity == nullptr || most < std::tuple_size_v<protection::Key>) return 0;
    auto found = handshake.owner.find_key_(identity);
    if (found) {
        handshake.identity = identity;
    } else {
        // A key that nobody has: the stranger does not learn who is known here.
        handshake.identity.clear();
        found.emplace();
        protection::hkdf_sha256(handshake.owner.secret_, {}, "ROMANO DTLS nobody ",
                                as_octets(identity), *found);
    }
    std::copy(found->begin(), found->end(), key);
    return static_cast<unsigned int>(found->size());
}

// --- steps

std::optional<Agreed> Handshakes::take(Instant now, const Path& path, const Record& record,
                                       Actions& out) {
    const auto hello = client_hello_in(record);
    const auto found = going_on_.find(path);
    const bool is_known = found != going_on_.end();
    // A client that began anew from the same port has another random.
    if (hello && (!is_known || found->second->client_random != hello->random)) {
        return begin(now, path, record, *hello, out);
    }
    if (!is_known || found->second->has_failed()) return std::nullopt;
    return step(*found->second, record.whole, out);
}

std::optional<Agreed> Handshakes::begin(Instant now, const Path& path, const Record& record,
                                        const ClientHello& hello, Actions& out) {
    const Cookie own = cookie_of(cookie_key_, path);
    if (!is_same(own, hello.cookie)) {
        put_verify_request(record, own, out.reserve(verify_request_octets));
        send(path, verify_request_octets, out);
        return std::nullopt;
    }
    if (!make_room(now, path)) {
        ++crowded_out_;
        return std::nullopt;
    }
    Handshake& handshake = *(going_on_[path] = std::make_unique<Handshake>(*this, context_.get()));
    handshake.path = path;
    handshake.began = now;
    handshake.client_random = hello.random;
    handshake.out = &out;
    handshake.set_input(record.whole);
    static const auto free_address = [](BIO_ADDR* address) { BIO_ADDR_free(address); };
    static const std::unique_ptr<BIO_ADDR, decltype(free_address)> not_asked_for{BIO_ADDR_new(),
                                                                                 free_address};
    ERR_clear_error();
    const bool is_heeded = DTLSv1_listen(handshake.ssl.get(), not_asked_for.get()) == 1;
    handshake.set_input({});
    if (is_heeded) return step(handshake, {}, out);
    fail(handshake);
    return std::nullopt;
}

bool Handshakes::make_room(Instant now, const Path& path) {
    const auto makes_way = [now](const auto& each) {
        return each.second->is_agreed || now - each.second->began >= least_turn;
    };
    if (const auto before = going_on_.find(path); before != going_on_.end()) {
        if (!makes_way(*before)) return false;
        drop(before);
    }
    auto oldest = going_on_.end();
    auto oldest_of_host = going_on_.end();
    std::size_t of_host = 0;
    for (auto each = going_on_.begin(); each != going_on_.end(); ++each) {
        const auto is_older_than = [&](GoingOn::iterator other) {
            return makes_way(*each) &&
                   (other == going_on_.end() || each->second->began < other->second->began);
        };
        if (is_older_than(oldest)) oldest = each;
        if (each->first.from.address != path.from.address) continue;
        ++of_host;
        if (is_older_than(oldest_of_host)) oldest_of_host = each;
    }
    const bool is_host_full = of_host >= most_of_host;
    if (!is_host_full && going_on_.size() < most_handshakes) return true;
    const auto goes = is_host_full ? oldest_of_host : oldest;
    if (goes == going_on_.end()) return false;
    drop(goes);
    return true;
}

void Handshakes::drop(GoingOn::iterator handshake) {
    fail(*handshake->second);
    going_on_.erase(handshake);
}

void Handshakes::fail(Handshake& handshake) {
    if (!handshake.is_agreed && !handshake.has_failed()) ++failed_;
    handshake.ssl.reset();
}

std::optional<Agreed> Handshakes::step(Handshake& handshake, Bytes record, Actions& out) {
    SSL* ssl = handshake.ssl.get();
    handshake.set_input(record);
    handshake.out = &out;
    std::optional<Agreed> agreed;
    ERR_clear_error();
    if (handshake.is_agreed) {  // a Finished that came again: its answer was lost
        std::array<std::uint8_t, 64> nothing{};
        (void)SSL_read(ssl, nothing.data(), static_cast<int>(nothing.size()));
    } else {
        const int done = SSL_do_handshake(ssl);
        const bool goes_on = done != 1 && SSL_get_error(ssl, done) == SSL_ERROR_WANT_READ;
        if (done == 1) agreed = agreement(handshake);
        if (agreed) {
            ++agreed_;
            handshake.is_agreed = true;
        } else if (!goes_on) {
            fail(handshake);
        }
    }
    handshake.set_input({});
    return agreed;
}

std::optional<Agreed> Handshakes::agreement(const Handshake& handshake) {
    const auto session = session_keys(handshake.ssl.get());
    if (!session || handshake.identity.empty()) return std::nullopt;
    const AssociationId id = handshake.clients_id ? handshake.id : AssociationId{session->rest};
    return Agreed{handshake.identity, id, handshake.path, session->keys, handshake.clients_id};
}

/// Once it is agreed on, what is no repeated Finished is an association's.
std::optional<Record> Handshakes::without_id(const Path& path, const Record& record) {
    const auto found = going_on_.find(path);
    if (found == going_on_.end()) return std::nullopt;
    const Handshake& handshake = *found->second;
    if (handshake.has_failed() || !handshake.clients_id || own_id_of(record.id) != handshake.id)
        return std::nullopt;
    const auto plain = ids_.without_id(session_keys(handshake.ssl.get()), record);
    const bool is_its = plain && (plain->type == ContentType::handshake ||
                                  (plain->type == ContentType::alert && !handshake.is_agreed));
    return is_its ? plain : std::nullopt;
}

void Handshakes::on_heard(const Path& path) {
    const auto found = going_on_.find(path);
    if (found != going_on_.end() && found->second->is_agreed) going_on_.erase(found);
}

void Handshakes::on_time(Instant now, Actions& out) {
    std::erase_if(going_on_, [&](const auto& each) {
        Handshake& handshake = *each.second;
        const bool is_over = now - handshake.began > patience;
        if (is_over) fail(handshake);
        if (handshake.has_failed()) return is_over || now - handshake.began >= least_turn;
        if (!handshake.is_agreed) {
            ERR_clear_error();
            handshake.out = &out;
            (void)DTLSv1_handle_timeout(handshake.ssl.get());
        }
        return false;
    });
}

}  // namespace romano::dtls
