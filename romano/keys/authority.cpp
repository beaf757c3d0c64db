#include "romano/keys/authority.h"

#include <openssl/bio.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/pkcs7.h>
#include <openssl/x509.h>
#include <openssl/x509v3.h>

#include <array>
#include <cstdint>
#include <utility>

#include "romano/keys/key_error.h"
#include "romano/keys/private_file.h"
#include "romano/keys/random_octets.h"

namespace romano::keys {
namespace {

constexpr const char* organization_of_brokers = "ROMANO brokers";
constexpr int clocks_differ_by_s = 3600;

struct FreeParts {
    void operator()(BIO* bio) const { BIO_free(bio); }
    void operator()(X509* certificate) const { X509_free(certificate); }
    void operator()(X509_EXTENSION* extension) const { X509_EXTENSION_free(extension); }
    void operator()(X509_CRL* list) const { X509_CRL_free(list); }
    void operator()(X509_REVOKED* entry) const { X509_REVOKED_free(entry); }
    void operator()(ASN1_TIME* time) const { ASN1_TIME_free(time); }
    void operator()(EVP_PKEY* key) const { EVP_PKEY_free(key); }
    void operator()(PKCS7* signature) const { PKCS7_free(signature); }
};
template <typename T>
using Owned = std::unique_ptr<T, FreeParts>;
using Memory = Owned<BIO>;

/// Of what does not go wrong but for want of memory.
void insist(bool is_done) {
    if (!is_done) throw KeyError("a certificate cannot be made: OpenSSL refuses");
}

Memory reader_of(const std::string& text) {
    return Memory{BIO_new_mem_buf(text.data(), static_cast<int>(text.size()))};
}

template <typename Write>
std::string written(Write&& write) {
    const Memory memory{BIO_new(BIO_s_mem())};
    insist(memory != nullptr && write(memory.get()) == 1);
    char* data = nullptr;
    const auto size = BIO_get_mem_data(memory.get(), &data);
    return {data, static_cast<std::size_t>(size)};
}

std::string pem_of(X509* certificate) {
    return written([&](BIO* to) { return PEM_write_bio_X509(to, certificate); });
}
std::string pem_of(EVP_PKEY* key) {
    return written([&](BIO* to) {
        return PEM_write_bio_PrivateKey(to, key, nullptr, nullptr, 0, nullptr, nullptr);
    });
}

std::string pem_of(X509_CRL* list) {
    return written([&](BIO* to) { return PEM_write_bio_X509_CRL(to, list); });
}

Owned<X509> certificate_in(const std::string& pem) {
    return Owned<X509>{PEM_read_bio_X509(reader_of(pem).get(), nullptr, nullptr, nullptr)};
}
Owned<X509_CRL> revocations_in(const std::string& pem) {
    return Owned<X509_CRL>{PEM_read_bio_X509_CRL(reader_of(pem).get(), nullptr, nullptr, nullptr)};
}

EVP_PKEY* new_key() {
    EVP_PKEY* key = EVP_EC_gen("P-256");
    insist(key != nullptr);
    return key;
}

void extend(X509* certificate, X509* issuer, int what, const char* value) {
    X509V3_CTX context;
    X509V3_set_ctx_nodb(&context);
    X509V3_set_ctx(&context, issuer, certificate, nullptr, nullptr, 0);
    const Owned<X509_EXTENSION> extension{X509V3_EXT_conf_nid(nullptr, &context, what, value)};
    insist(extension != nullptr && X509_add_ext(certificate, extension.get(), -1) == 1);
}

void add_to_name(X509_NAME* subject, const char* field, std::string_view value) {
    insist(X509_NAME_add_entry_by_txt(subject, field, MBSTRING_ASC,
                                      reinterpret_cast<const unsigned char*>(value.data()),
                                      static_cast<int>(value.size()), -1, 0) == 1);
}

/// All but its subject, its extensions and the signature. Clocks of robots are an hour wrong at
/// most.
X509* unsigned_certificate(EVP_PKEY* key, int days) {
    X509* certificate = X509_new();
    insist(certificate != nullptr);
    std::array<std::uint8_t, 16> serial{};
    fill_at_random(serial);
    std::uint64_t number = 0;
    for (std::size_t i = 0; i < 8; ++i) number = number << 8U | serial[i];
    insist(X509_set_version(certificate, X509_VERSION_3) == 1 &&
           ASN1_INTEGER_set_uint64(X509_get_serialNumber(certificate), number >> 1U) == 1 &&
           X509_gmtime_adj(X509_getm_notBefore(certificate), -clocks_differ_by_s) != nullptr &&
           X509_time_adj_ex(X509_getm_notAfter(certificate), days, 0, nullptr) != nullptr &&
           X509_set_pubkey(certificate, key) == 1);
    return certificate;
}

}  // namespace

void Authority::Free::operator()(x509_st* certificate) const {
    X509_free(certificate);
}
void Authority::Free::operator()(evp_pkey_st* key) const {
    EVP_PKEY_free(key);
}

Authority::Authority(const std::filesystem::path& fleet) {
    const auto certificate_file = fleet / authority_name;
    const auto key_file = fleet / authority_key_name;
    if (!std::filesystem::exists(key_file)) {
        key_.reset(new_key());
        certificate_.reset(unsigned_certificate(key_.get(), own_days));
        X509* own = certificate_.get();
        add_to_name(X509_get_subject_name(own), "CN", "ROMANO fleet authority");
        insist(X509_set_issuer_name(own, X509_get_subject_name(own)) == 1);
        extend(own, own, NID_basic_constraints, "critical,CA:TRUE,pathlen:0");
        extend(own, own, NID_key_usage, "critical,keyCertSign,cRLSign,digitalSignature");
        extend(own, own, NID_subject_key_identifier, "hash");
        insist(X509_sign(own, key_.get(), EVP_sha256()) != 0);
        text_ = pem_of(own);
        write_private_file(certificate_file, text_);
        write_private_file(key_file, pem_of(key_.get()));
        return;
    }
    text_ = read_private_file(certificate_file);
    certificate_.reset(PEM_read_bio_X509(reader_of(text_).get(), nullptr, nullptr, nullptr));
    if (!certificate_) throw KeyError(certificate_file.string() + ": is no certificate");
    const std::string key = read_private_file(key_file);
    key_.reset(PEM_read_bio_PrivateKey(reader_of(key).get(), nullptr, nullptr, nullptr));
    if (!key_ || X509_check_private_key(certificate_.get(), key_.get()) != 1) {
        throw KeyError(key_file.string() + ": is not the private key of " +
                       certificate_file.string());
    }
}
Authority::~Authority() = default;

std::string Authority::issue(std::string_view name, Holder holder, int days) const {
    const std::unique_ptr<evp_pkey_st, Free> key{new_key()};
    const std::unique_ptr<x509_st, Free> made{unsigned_certificate(key.get(), days)};
    X509_NAME* subject = X509_get_subject_name(made.get());
    if (holder == Holder::broker) add_to_name(subject, "O", organization_of_brokers);
    add_to_name(subject, "CN", name);
    insist(X509_set_issuer_name(made.get(), X509_get_subject_name(certificate_.get())) == 1);
    extend(made.get(), certificate_.get(), NID_basic_constraints, "critical,CA:FALSE");
    extend(made.get(), certificate_.get(), NID_key_usage, "critical,digitalSignature");
    extend(made.get(), certificate_.get(), NID_ext_key_usage,
           holder == Holder::broker ? "serverAuth" : "clientAuth");
    extend(made.get(), certificate_.get(), NID_authority_key_identifier, "keyid");
    if (holder == Holder::broker) {
        // Clients of HTTPS look for a server's name there alone.
        extend(made.get(), certificate_.get(), NID_subject_alt_name,
               ("DNS:" + std::string{name}).c_str());
    }
    insist(X509_sign(made.get(), key_.get(), EVP_sha256()) != 0);
    return pem_of(made.get()) + pem_of(key.get());
}

std::string Authority::sign(const std::string& text) const {
    constexpr int flags = PKCS7_TEXT | PKCS7_DETACHED;
    const Owned<PKCS7> signature{
        PKCS7_sign(certificate_.get(), key_.get(), nullptr, reader_of(text).get(), flags)};
    insist(signature != nullptr);
    return written([&](BIO* to) {
        return SMIME_write_PKCS7(to, signature.get(), reader_of(text).get(), flags);
    });
}

std::string Authority::revocations(const std::optional<std::string>& earlier,
                                   const std::optional<std::string>& revoked) const {
    Owned<X509_CRL> list{earlier ? revocations_in(*earlier).release() : X509_CRL_new()};
    if (list == nullptr) throw KeyError("is no list of revoked certificates");
    const Owned<ASN1_TIME> now{X509_gmtime_adj(nullptr, 0)};
    const Owned<ASN1_TIME> from{X509_gmtime_adj(nullptr, -clocks_differ_by_s)};
    const Owned<ASN1_TIME> until{X509_time_adj_ex(nullptr, own_days, 0, nullptr)};
    insist(X509_CRL_set_version(list.get(), X509_CRL_VERSION_2) == 1 &&
           X509_CRL_set_issuer_name(list.get(), X509_get_subject_name(certificate_.get())) == 1 &&
           X509_CRL_set1_lastUpdate(list.get(), from.get()) == 1 &&
           X509_CRL_set1_nextUpdate(list.get(), until.get()) == 1);
    if (revoked) {
        const Owned<X509> whose = certificate_in(*revoked);
        if (whose == nullptr) throw KeyError("is no certificate");
        Owned<X509_REVOKED> entry{X509_REVOKED_new()};
        insist(X509_REVOKED_set_serialNumber(entry.get(), X509_get_serialNumber(whose.get())) ==
                   1 &&
               X509_REVOKED_set_revocationDate(entry.get(), now.get()) == 1 &&
               X509_CRL_add0_revoked(list.get(), entry.get()) == 1);
        (void)entry.release();  // the list's by now
    }
    insist(X509_CRL_sort(list.get()) == 1 &&
           X509_CRL_sign(list.get(), key_.get(), EVP_sha256()) != 0);
    return pem_of(list.get());
}

std::string subject_of_broker(std::string_view name) {
    return "CN=" + std::string{name} + ",O=" + organization_of_brokers;
}

bool is_signed_by(const std::string& pem, const std::string& authority) {
    const Owned<X509> certificate = certificate_in(pem);
    const Owned<X509> of_authority = certificate_in(authority);
    return certificate && of_authority &&
           X509_verify(certificate.get(), X509_get0_pubkey(of_authority.get())) == 1;
}

bool is_revoked(const std::string& pem, const std::string& revocations) {
    const Owned<X509> certificate = certificate_in(pem);
    const Owned<X509_CRL> list = revocations_in(revocations);
    X509_REVOKED* entry = nullptr;
    return certificate && list && X509_CRL_get0_by_cert(list.get(), &entry, certificate.get()) == 1;
}

std::optional<std::string> flaw_of(const std::string& pem) {
    const Owned<X509> certificate = certificate_in(pem);
    if (!certificate) return "is no certificate";
    if (X509_cmp_current_time(X509_get0_notBefore(certificate.get())) > 0) {
        return "is not valid yet; is this computer's clock right?";
    }
    if (X509_cmp_current_time(X509_get0_notAfter(certificate.get())) < 0) {
        return "has expired; `romano keys certificate` (a broker: `romano keys renew`) makes "
               "another one";
    }
    return std::nullopt;
}

}  // namespace romano::keys
