#include "romano/dtls/record/record_cipher.h"

#include <openssl/evp.h>

#include <algorithm>
#include <new>

namespace romano::dtls {
namespace {

constexpr int nonce_octets = 12;
using Nonce = std::array<std::uint8_t, nonce_octets>;

/// What is authenticated beside the message.
class Readable {
public:
    /// RFC 5246 section 6.2.3.3, `message` octets; with an id RFC 9146 section 5.3.
    Readable(ContentType type, std::uint64_t epoch_and_number, Bytes id, std::size_t message) {
        const auto octet_of = [](ContentType of) { return static_cast<std::uint8_t>(of); };
        if (id.empty()) {
            put_be64(octets_, 0, epoch_and_number);
            octets_[8] = octet_of(type);
            put_be16(octets_, 9, version_1_2);
            put_be16(octets_, 11, static_cast<std::uint16_t>(message));
            size_ = 13;
            return;
        }
        put_be64(octets_, 0, ~std::uint64_t{0});
        octets_[8] = octet_of(ContentType::with_id);
        octets_[9] = static_cast<std::uint8_t>(id.size());
        octets_[10] = octet_of(ContentType::with_id);
        put_be16(octets_, 11, version_1_2);
        put_be64(octets_, 13, epoch_and_number);
        std::copy(id.begin(), id.end(), octets_.begin() + 21);
        put_be16(octets_, 21 + id.size(), static_cast<std::uint16_t>(message));
        size_ = 23 + id.size();
    }
    [[nodiscard]] const std::uint8_t* data() const { return octets_.data(); }
    [[nodiscard]] int size() const { return static_cast<int>(size_); }

private:
    std::array<std::uint8_t, 23 + ConnectionId::most_octets> octets_;
    std::size_t size_;
};

Nonce nonce_of(const WriteKey& key, Bytes explicit_part) {
    Nonce nonce;
    const auto rest = std::copy(key.salt.begin(), key.salt.end(), nonce.begin());
    std::copy(explicit_part.begin(), explicit_part.end(), rest);
    return nonce;
}

int size_of(Bytes octets) {
    return static_cast<int>(octets.size());
}

/// RFC 9146 section 4: behind the message stand its type and any number of zeros.
std::optional<Opened> without_padding(Bytes inner) {
    while (!inner.empty() && inner.back() == 0) inner = inner.first(inner.size() - 1);
    if (inner.empty()) return std::nullopt;
    return Opened{ContentType{inner.back()}, inner.size() - 1};
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
                               std::uint64_t number, Bytes message, MutableBytes out, Bytes id) {
    const std::size_t size = message.size() + overhead(suite, id.size());
    const std::size_t header = header_octets + id.size();
    const std::size_t inner = message.size() + (id.empty() ? 0 : 1);
    EVP_CIPHER_CTX* context = sealing_[static_cast<std::size_t>(suite)].get();
    if (context == nullptr || message.empty() || message.size() > most_message ||
        id.size() > ConnectionId::most_octets || out.size() < size) {
        return 0;
    }
    const std::uint64_t numbered = epoch_and_number(1, number);
    put_header(out, id.empty() ? type : ContentType::with_id, numbered, id, size - header);
    put_be64(out, header, numbered);
    const Nonce nonce = nonce_of(key, out.subspan(header, explicit_nonce_octets));
    const Readable readable{type, numbered, id, inner};
    std::uint8_t* ciphertext = out.data() + header + explicit_nonce_octets;
    const std::uint8_t* plaintext = message.data();
    if (!id.empty()) {  // CCM takes all of it at once
        *std::copy(message.begin(), message.end(), ciphertext) = static_cast<std::uint8_t>(type);
        plaintext = ciphertext;
    }
    const int plaintext_size = static_cast<int>(inner);
    const int tag = static_cast<int>(tag_octets(suite));
    int done = 0;
    const bool is_sealed =
        EVP_EncryptInit_ex(context, nullptr, nullptr, key.key.data(), nonce.data()) == 1 &&
        (suite == Suite::aes_128_gcm ||
         EVP_EncryptUpdate(context, nullptr, &done, nullptr, plaintext_size) == 1) &&
        EVP_EncryptUpdate(context, nullptr, &done, readable.data(), readable.size()) == 1 &&
        EVP_EncryptUpdate(context, ciphertext, &done, plaintext, plaintext_size) == 1 &&
        EVP_EncryptFinal_ex(context, ciphertext + inner, &done) == 1 &&
        EVP_CIPHER_CTX_ctrl(context, EVP_CTRL_AEAD_GET_TAG, tag, ciphertext + inner) == 1;
    return is_sealed ? size : 0;
}

std::optional<Opened> RecordCipher::open(Suite suite, const WriteKey& key, const Record& record,
                                         MutableBytes out) {
    const std::size_t beside = explicit_nonce_octets + tag_octets(suite);
    EVP_CIPHER_CTX* context = opening_[static_cast<std::size_t>(suite)].get();
    if (context == nullptr || record.epoch != 1 || record.version != version_1_2 ||
        record.body.size() <= beside) {  // libcrypto does not verify an empty message of CCM
        return std::nullopt;
    }
    const Bytes ciphertext =
        record.body.subspan(explicit_nonce_octets, record.body.size() - beside);
    const std::size_t most = most_message + (record.id.empty() ? 0 : 1);
    if (ciphertext.size() > most || out.size() < ciphertext.size()) return std::nullopt;
    const Nonce nonce = nonce_of(key, record.body.first(explicit_nonce_octets));
    const Readable readable{record.type, epoch_and_number(1, record.number), record.id,
                            ciphertext.size()};
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
        EVP_DecryptUpdate(context, nullptr, &done, readable.data(), readable.size()) == 1;
    if (!is_set || EVP_DecryptUpdate(context, out.data(), &done, ciphertext.data(),
                                     size_of(ciphertext)) != 1) {
        return std::nullopt;
    }
    if (suite == Suite::aes_128_gcm &&
        EVP_DecryptFinal_ex(context, out.data() + ciphertext.size(), &done) != 1) {
        return std::nullopt;
    }
    if (record.id.empty()) return Opened{record.type, ciphertext.size()};
    return without_padding(out.first(ciphertext.size()));
}

}  // namespace romano::dtls
