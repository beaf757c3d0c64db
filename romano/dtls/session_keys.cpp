#include "romano/dtls/session_keys.h"

#include <openssl/core_names.h>
#include <openssl/crypto.h>
#include <openssl/kdf.h>
#include <openssl/params.h>
#include <openssl/ssl.h>

#include <algorithm>
#include <array>
#include <memory>
#include <string_view>

namespace romano::dtls {
namespace {

std::optional<Suite> suite_of(const SSL_CIPHER* cipher) {
    if (cipher == nullptr) return std::nullopt;
    switch (SSL_CIPHER_get_cipher_nid(cipher)) {
        case NID_aes_128_ccm:
            return Suite::aes_128_ccm_8;
        case NID_aes_128_gcm:
            return Suite::aes_128_gcm;
        default:
            return std::nullopt;
    }
}

struct FreeKdf {
    void operator()(EVP_KDF* kdf) const { EVP_KDF_free(kdf); }
    void operator()(EVP_KDF_CTX* context) const { EVP_KDF_CTX_free(context); }
};

bool expand(Bytes master, Bytes seed, MutableBytes out) {
    static const std::unique_ptr<EVP_KDF, FreeKdf> kdf{
        EVP_KDF_fetch(nullptr, OSSL_KDF_NAME_TLS1_PRF, nullptr)};
    const std::unique_ptr<EVP_KDF_CTX, FreeKdf> context{EVP_KDF_CTX_new(kdf.get())};
    if (!context) return false;
    std::array<char, 7> digest{"SHA256"};
    const auto octets = [](const char* name, Bytes value) {
        return OSSL_PARAM_construct_octet_string(name, const_cast<std::uint8_t*>(value.data()),
                                                 value.size());
    };
    const std::array<OSSL_PARAM, 4> parameters{
        OSSL_PARAM_construct_utf8_string(OSSL_KDF_PARAM_DIGEST, digest.data(), 0),
        octets(OSSL_KDF_PARAM_SECRET, master), octets(OSSL_KDF_PARAM_SEED, seed),
        OSSL_PARAM_construct_end()};
    return EVP_KDF_derive(context.get(), out.data(), out.size(), parameters.data()) == 1;
}

}  // namespace

std::optional<SessionKeys> session_keys(const ssl_st* ssl) {
    const SSL_SESSION* session = SSL_get_session(ssl);
    const auto suite = suite_of(SSL_get_pending_cipher(ssl));
    if (session == nullptr || !suite) return std::nullopt;
    std::array<std::uint8_t, 48> master{};
    constexpr std::string_view label = "key expansion";
    std::array<std::uint8_t, label.size() + 2 * 32> seed{};
    std::copy(label.begin(), label.end(), seed.begin());
    if (SSL_SESSION_get_master_key(session, master.data(), master.size()) != master.size() ||
        SSL_get_server_random(ssl, seed.data() + label.size(), 32) != 32 ||
        SSL_get_client_random(ssl, seed.data() + label.size() + 32, 32) != 32) {
        return std::nullopt;
    }
    std::array<std::uint8_t, 2 * 16 + 2 * 4 + 8> block{};
    const bool is_expanded = expand(master, seed, block);
    OPENSSL_cleanse(master.data(), master.size());
    if (!is_expanded) return std::nullopt;
    SessionKeys out{{*suite, {}, {}}};
    const std::uint8_t* at = block.data();
    const auto take = [&at](auto& to) {
        std::copy_n(at, to.size(), to.begin());
        at += to.size();
    };
    take(out.keys.client.key);
    take(out.keys.server.key);
    take(out.keys.client.salt);
    take(out.keys.server.salt);
    for (int i = 0; i < 8; ++i) out.rest = out.rest << 8U | *at++;
    OPENSSL_cleanse(block.data(), block.size());
    return out;
}

}  // namespace romano::dtls
