#include "broker/dtls/record_cipher.h"

#include <openssl/evp.h>

#include <algorithm>
#include <new>

namespace romano::dtls {
namespace {

constexpr int nonce_octets = 12;
using Nonce = std::array<std::uint8_t, nonce_octets>;
using Readable = std::array<std::uint8_t, 13>;

Nonce nonce_of(const WriteKey& key, Bytes explicit_part) {
    Nonce nonce;
    const auto rest = std::copy(key.salt.begin(), key.salt.end(), nonce.begin());
    std::copy(explicit_part.begin(), explicit_part.end(), rest);
    return nonce;
}

/// RFC 5246 section 6.2.3.3: what is authenticated beside the message, whose length it holds.
Readable readable_of(ContentType type, std::uint64_t epoch_and_number, std::size_t message) {
    Readable out;
    put_be64(out, 0, epoch_and_number);
    out[8] = static_cast<std::uint8_t>(type);
    put_be16(out, 9, version_1_2);
    put_be16(out, 11, static_cast<std::uint16_t>(message));
    return out;
}

int size_of(Bytes octets) {
    return static_cast<int>(octets.size());
}

}  // namespace

void RecordCipher::FreeContext::operator()(evp_cipher_ctx_st* context) const {
    EVP_CIPHER_CTX_free(context);
}

RecordCipher::Context RecordCipher::context_of(Suite suite, bool seals) {
    Context context{EVP_CIPHER_CTX_new()};
    const EVP_CIPHER* cipher =
        suite == Suite::aes_128_ccm_8 ? EVP_aes_128_ccm() : EVP_aes_128_gcm();
    const int tag = static_cast<int>(tag_octets(suite));
    const bool is_made =
        context &&
        EVP_CipherInit_ex(context.get(), cipher, nullptr, nullptr, nullptr, seals) == 1 &&
        EVP_CIPHER_CTX_ctrl(context.get(), EVP_CTRL_AEAD_SET_IVLEN, nonce_octets, nullptr) == 1 &&
        (suite == Suite::aes_128_gcm ||
         EVP_CIPHER_CTX_ctrl(context.get(), EVP_CTRL_AEAD_SET_TAG, tag, nullptr) == 1);
    return is_made ? std::move(context) : nullptr;
}

RecordCipher::RecordCipher() {
    for (const Suite suite : {Suite::aes_128_ccm_8, Suite::aes_128_gcm}) {
        const auto at = static_cast<std::size_t>(suite);
        sealing_[at] = context_of(suite, true);
        opening_[at] = context_of(suite, false);
    }
}
RecordCipher::~RecordCipher() = default;

std::size_t RecordCipher::seal(Suite suite, const WriteKey& key, ContentType type,
                               std::uint64_t number, Bytes message, MutableBytes out) {
    const std::size_t size = message.size() + overhead(suite);
    EVP_CIPHER_CTX* context = sealing_[static_cast<std::size_t>(suite)].get();
    if (context == nullptr || message.empty() || message.size() > most_message ||
        out.size() < size) {
        return 0;
    }
    const std::uint64_t numbered = epoch_and_number(1, number);
    put_header(out, type, numbered, size - header_octets);
    put_be64(out, header_octets, numbered);
    const Nonce nonce = nonce_of(key, out.subspan(header_octets, explicit_nonce_octets));
    const Readable readable = readable_of(type, numbered, message.size());
    std::uint8_t* ciphertext = out.data() + header_octets + explicit_nonce_octets;
    const int tag = static_cast<int>(tag_octets(suite));
    int done = 0;
    const bool is_sealed =
        EVP_EncryptInit_ex(context, nullptr, nullptr, key.key.data(), nonce.data()) == 1 &&
        (suite == Suite::aes_128_gcm ||
         EVP_EncryptUpdate(context, nullptr, &done, nullptr, size_of(message)) == 1) &&
        EVP_EncryptUpdate(context, nullptr, &done, readable.data(), size_of(readable)) == 1 &&
        EVP_EncryptUpdate(context, ciphertext, &done, message.data(), size_of(message)) == 1 &&
        EVP_EncryptFinal_ex(context, ciphertext + message.size(), &done) == 1 &&
        EVP_CIPHER_CTX_ctrl(context, EVP_CTRL_AEAD_GET_TAG, tag, ciphertext + message.size()) == 1;
    return is_sealed ? size : 0;
}

std::optional<std::size_t> RecordCipher::open(Suite suite, const WriteKey& key,
                                              const Record& record, MutableBytes out) {
    const std::size_t beside = explicit_nonce_octets + tag_octets(suite);
    EVP_CIPHER_CTX* context = opening_[static_cast<std::size_t>(suite)].get();
    if (context == nullptr || record.epoch != 1 || record.version != version_1_2 ||
        record.body.size() <= beside) {  // libcrypto does not verify an empty message of CCM
        return std::nullopt;
    }
    const Bytes ciphertext =
        record.body.subspan(explicit_nonce_octets, record.body.size() - beside);
    if (ciphertext.size() > most_message || out.size() < ciphertext.size()) return std::nullopt;
    const Nonce nonce = nonce_of(key, record.body.first(explicit_nonce_octets));
    const Readable readable =
        readable_of(record.type, epoch_and_number(1, record.number), ciphertext.size());
    std::array<std::uint8_t, 16> tag{};
    const Bytes tail = record.body.last(tag_octets(suite));
    std::copy(tail.begin(), tail.end(), tag.begin());
    int done = 0;
    // CCM is verified by its update, GCM by its end. The tag of CCM is set before the key.
    const bool is_set =
        EVP_CIPHER_CTX_ctrl(context, EVP_CTRL_AEAD_SET_TAG, size_of(tail), tag.data()) == 1 &&
        EVP_DecryptInit_ex(context, nullptr, nullptr, key.key.data(), nonce.data()) == 1 &&
        (suite == Suite::aes_128_gcm ||
         EVP_DecryptUpdate(context, nullptr, &done, nullptr, size_of(ciphertext)) == 1) &&
        EVP_DecryptUpdate(context, nullptr, &done, readable.data(), size_of(readable)) == 1;
    if (!is_set || EVP_DecryptUpdate(context, out.data(), &done, ciphertext.data(),
                                     size_of(ciphertext)) != 1) {
        return std::nullopt;
    }
    if (suite == Suite::aes_128_gcm &&
        EVP_DecryptFinal_ex(context, out.data() + ciphertext.size(), &done) != 1) {
        return std::nullopt;
    }
    return ciphertext.size();
}

}  // namespace romano::dtls
