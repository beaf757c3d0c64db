#include "romano/protection/packet_cipher.h"

#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <memory>
#include <tuple>
#include <utility>

namespace romano::protection {
namespace {

struct Free {
    void operator()(EVP_CIPHER_CTX* context) const { EVP_CIPHER_CTX_free(context); }
    void operator()(EVP_MD_CTX* context) const { EVP_MD_CTX_free(context); }
    void operator()(EVP_MD* digest) const { EVP_MD_free(digest); }
};

/// Made once a thread: that takes longer than a packet.
struct Ciphers {
    Ciphers()
        : sha256(EVP_MD_fetch(nullptr, "SHA256", nullptr)),
          hashing(EVP_MD_CTX_new()),
          sealing(context_of(true)),
          opening(context_of(false)) {}

    static std::unique_ptr<EVP_CIPHER_CTX, Free> context_of(bool seals) {
        std::unique_ptr<EVP_CIPHER_CTX, Free> context{EVP_CIPHER_CTX_new()};
        const bool is_made =
            context &&
            EVP_CipherInit_ex(context.get(), EVP_aes_128_ccm(), nullptr, nullptr, nullptr, seals) ==
                1 &&
            EVP_CIPHER_CTX_ctrl(context.get(), EVP_CTRL_AEAD_SET_IVLEN, std::tuple_size_v<Nonce>,
                                nullptr) == 1 &&
            EVP_CIPHER_CTX_ctrl(context.get(), EVP_CTRL_AEAD_SET_TAG, tag_size, nullptr) == 1;
        return is_made ? std::move(context) : nullptr;
    }

    std::unique_ptr<EVP_MD, Free> sha256;
    std::unique_ptr<EVP_MD_CTX, Free> hashing;
    std::unique_ptr<EVP_CIPHER_CTX, Free> sealing;
    std::unique_ptr<EVP_CIPHER_CTX, Free> opening;
};

Ciphers& own() {
    thread_local Ciphers ciphers;
    return ciphers;
}

int size_of(Bytes octets) {
    return static_cast<int>(octets.size());
}

/// What goes wrong here is want of memory: no packet may leave half sealed.
void insist(bool is_done) {
    if (!is_done) std::abort();
}

}  // namespace

Nonce nonce_of(Bytes header) {
    const Ciphers& ciphers = own();
    std::array<std::uint8_t, 32> digest{};
    insist(EVP_DigestInit_ex2(ciphers.hashing.get(), ciphers.sha256.get(), nullptr) == 1 &&
           EVP_DigestUpdate(ciphers.hashing.get(), header.data(), header.size()) == 1 &&
           EVP_DigestFinal_ex(ciphers.hashing.get(), digest.data(), nullptr) == 1);
    Nonce nonce;
    std::copy_n(digest.begin(), nonce.size(), nonce.begin());
    return nonce;
}

void seal(const Key& key, Bytes header, MutableBytes message, MutableBytes tag) {
    EVP_CIPHER_CTX* context = own().sealing.get();
    const Nonce nonce = nonce_of(header);
    int done = 0;
    insist(context != nullptr &&
           EVP_EncryptInit_ex(context, nullptr, nullptr, key.data(), nonce.data()) == 1 &&
           EVP_EncryptUpdate(context, nullptr, &done, nullptr, size_of(message)) == 1 &&
           EVP_EncryptUpdate(context, nullptr, &done, header.data(), size_of(header)) == 1 &&
           EVP_EncryptUpdate(context, message.data(), &done, message.data(), size_of(message)) ==
               1 &&
           EVP_CIPHER_CTX_ctrl(context, EVP_CTRL_AEAD_GET_TAG, size_of(tag), tag.data()) == 1);
}

bool open(const Key& key, Bytes header, MutableBytes message, Bytes tag) {
    EVP_CIPHER_CTX* context = own().opening.get();
    if (message.empty()) return false;  // libcrypto would not look at the tag
    const Nonce nonce = nonce_of(header);
    std::array<std::uint8_t, tag_size> expected{};
    std::copy_n(tag.begin(), expected.size(), expected.begin());
    int done = 0;
    // The tag is set before the key, and is looked at by the last update.
    insist(context != nullptr &&
           EVP_CIPHER_CTX_ctrl(context, EVP_CTRL_AEAD_SET_TAG, tag_size, expected.data()) == 1 &&
           EVP_DecryptInit_ex(context, nullptr, nullptr, key.data(), nonce.data()) == 1 &&
           EVP_DecryptUpdate(context, nullptr, &done, nullptr, size_of(message)) == 1 &&
           EVP_DecryptUpdate(context, nullptr, &done, header.data(), size_of(header)) == 1);
    if (EVP_DecryptUpdate(context, message.data(), &done, message.data(), size_of(message)) == 1) {
        return true;
    }
    std::fill(message.begin(), message.end(), std::uint8_t{0});
    return false;
}

}  // namespace romano::protection
