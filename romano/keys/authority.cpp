#include "romano/keys/authority.h"

#include <openssl/bio.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
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

struct FreeParts {
    void operator()(BIO* bio) const { BIO_free(bio); }
    void operator()(X509_EXTENSION* extension) const { X509_EXTENSION_free(extension); }
};
using Memory = std::unique_ptr<BIO, FreeParts>;

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

EVP_PKEY* new_key() {
    EVP_PKEY* key = EVP_EC_gen("P-256");
    insist(key != nullptr);
    return key;
}

void extend(X509* certificate, X509* issuer, int what, const char* value) {
    X509V3_CTX context;
    X509V3_set_ctx_nodb(&context);
    X509V3_set_ctx(&context, issuer, certificate, nullptr, nullptr, 0);
    const std::unique_ptr<X509_EXTENSION, FreeParts> extension{
        X509V3_EXT_conf_nid(nullptr, &context, what, value)};
    insist(extension != nullptr && X509_add_ext(certificate, extension.get(), -1) == 1);
}

/// All but its extensions and the signature. Clocks of robots are an hour wrong at most.
X509* unsigned_certificate(std::string_view name, EVP_PKEY* key, int days) {
    X509* certificate = X509_new();
    insist(certificate != nullptr);
    std::array<std::uint8_t, 16> serial{};
    fill_at_random(serial);
    std::uint64_t number = 0;
    for (std::size_t i = 0; i < 8; ++i) number = number << 8U | serial[i];
    X509_NAME* subject = X509_get_subject_name(certificate);
    insist(X509_set_version(certificate, X509_VERSION_3) == 1 &&
           ASN1_INTEGER_set_uint64(X509_get_serialNumber(certificate), number >> 1U) == 1 &&
           X509_gmtime_adj(X509_getm_notBefore(certificate), -3600) != nullptr &&
           X509_time_adj_ex(X509_getm_notAfter(certificate), days, 0, nullptr) != nullptr &&
           X509_NAME_add_entry_by_txt(subject, "CN", MBSTRING_ASC,
                                      reinterpret_cast<const unsigned char*>(name.data()),
                                      static_cast<int>(name.size()), -1, 0) == 1 &&
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
        certificate_.reset(unsigned_certificate("ROMANO fleet authority", key_.get(), own_days));
        X509* own = certificate_.get();
        insist(X509_set_issuer_name(own, X509_get_subject_name(own)) == 1);
        extend(own, own, NID_basic_constraints, "critical,CA:TRUE,pathlen:0");
        extend(own, own, NID_key_usage, "critical,keyCertSign,cRLSign");
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
    const std::unique_ptr<x509_st, Free> made{unsigned_certificate(name, key.get(), days)};
    insist(X509_set_issuer_name(made.get(), X509_get_subject_name(certificate_.get())) == 1);
    extend(made.get(), certificate_.get(), NID_basic_constraints, "critical,CA:FALSE");
    extend(made.get(), certificate_.get(), NID_key_usage, "critical,digitalSignature");
    extend(made.get(), certificate_.get(), NID_ext_key_usage,
           holder == Holder::broker ? "serverAuth" : "clientAuth");
    extend(made.get(), certificate_.get(), NID_authority_key_identifier, "keyid");
    insist(X509_sign(made.get(), key_.get(), EVP_sha256()) != 0);
    return pem_of(made.get()) + pem_of(key.get());
}

std::optional<std::string> flaw_of(const std::string& pem) {
    const std::unique_ptr<X509, decltype(&X509_free)> certificate{
        PEM_read_bio_X509(reader_of(pem).get(), nullptr, nullptr, nullptr), X509_free};
    if (!certificate) return "is no certificate";
    if (X509_cmp_current_time(X509_get0_notBefore(certificate.get())) > 0) {
        return "is not valid yet; is this computer's clock right?";
    }
    if (X509_cmp_current_time(X509_get0_notAfter(certificate.get())) < 0) {
        return "has expired; `romano keys certificate` makes another one";
    }
    return std::nullopt;
}

}  // namespace romano::keys
