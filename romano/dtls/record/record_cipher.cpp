#include "romano/dtls/record/record_cipher.h"

#include <openssl/evp.h>

#include <algorithm>
#include <utility>

#include "romano/protection/libcrypto/scheduled_ccm.h"

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
    [[nodiscard]] Bytes octets() const { return Bytes{octets_}.first(size_); }

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

bool seal_gcm(EVP_CIPHER_CTX* context, const WriteKey& key, const Nonce& nonce, Bytes readable,
              MutableBytes message, MutableBytes tag) {
    int done = 0;
    return context != nullptr &&
           EVP_EncryptInit_ex(context, nullptr, nullptr, key.key.data(), nonce.data()) == 1 &&
           EVP_EncryptUpdate(context, nullptr, &done, readable.data(), size_of(readable)) == 1 &&
           EVP_EncryptUpdate(context, message.data(), &done, message.data(), size_of(message)) ==
               1 &&
           EVP_EncryptFinal_ex(context, message.data() + message.size(), &done) == 1 &&
           EVP_CIPHER_CTX_ctrl(context, EVP_CTRL_AEAD_GET_TAG, size_of(tag), tag.data()) == 1;
}

bool open_gcm(EVP_CIPHER_CTX* context, const WriteKey& key, const Nonce& nonce, Bytes readable,
              MutableBytes message, Bytes tag) {
    std::array<std::uint8_t, 16> expected{};
    std::ranges::copy(tag, expected.begin());
    int done = 0;
    return context != nullptr &&
           EVP_DecryptInit_ex(context, nullptr, nullptr, key.key.data(), nonce.data()) == 1 &&
           EVP_DecryptUpdate(context, nullptr, &done, readable.data(), size_of(readable)) == 1 &&
           EVP_DecryptUpdate(context, message.data(), &done, message.data(), size_of(message)) ==
               1 &&
           EVP_CIPHER_CTX_ctrl(context, EVP_CTRL_AEAD_SET_TAG, size_of(tag), expected.data()) ==
               1 &&
           EVP_DecryptFinal_ex(context, message.data() + message.size(), &done) == 1;
}

}  // namespace

void RecordCipher::FreeContext::operator()(evp_cipher_ctx_st* context) const {
    EVP_CIPHER_CTX_free(context);
}

RecordCipher::Context RecordCipher::gcm(bool seals) {
    Context context{EVP_CIPHER_CTX_new()};
    const bool is_made =
        context &&
        EVP_CipherInit_ex(context.get(), EVP_aes_128_gcm(), nullptr, nullptr, nullptr, seals) ==
            1 &&
        EVP_CIPHER_CTX_ctrl(context.get(), EVP_CTRL_AEAD_SET_IVLEN, nonce_octets, nullptr) == 1;
    return is_made ? std::move(context) : nullptr;
}

RecordCipher::RecordCipher() : sealing_(gcm(true)), opening_(gcm(false)) {}
RecordCipher::~RecordCipher() = default;

std::size_t RecordCipher::seal(Suite suite, const WriteKey& key, ContentType type,
                               std::uint64_t number, Bytes message, MutableBytes out, Bytes id) {
    const std::size_t size = message.size() + overhead(suite, id.size());
    const std::size_t header = header_octets + id.size();
    if (message.empty() || message.size() > most_message || id.size() > ConnectionId::most_octets ||
        out.size() < size) {
        return 0;
    }
    const std::uint64_t numbered = epoch_and_number(1, number);
    put_header(out, id.empty() ? type : ContentType::with_id, numbered, id, size - header);
    put_be64(out, header, numbered);
    const MutableBytes inner =
        out.subspan(header + explicit_nonce_octets, message.size() + (id.empty() ? 0 : 1));
    std::ranges::copy(message, inner.begin());
    if (!id.empty()) inner.back() = static_cast<std::uint8_t>(type);
    const MutableBytes tag = out.subspan(size - tag_octets(suite), tag_octets(suite));
    const Nonce nonce = nonce_of(key, out.subspan(header, explicit_nonce_octets));
    const Readable readable{type, numbered, id, inner.size()};
    if (suite == Suite::aes_128_ccm_8) {
        protection::ScheduledCcm::of(key.key).seal(nonce, readable.octets(), inner, tag);
        return size;
    }
    return seal_gcm(sealing_.get(), key, nonce, readable.octets(), inner, tag) ? size : 0;
}

std::optional<Opened> RecordCipher::open(Suite suite, const WriteKey& key, const Record& record,
                                         MutableBytes out) {
    const std::size_t beside = explicit_nonce_octets + tag_octets(suite);
    if (record.epoch != 1 || record.version != version_1_2 || record.body.size() <= beside) {
        return std::nullopt;
    }
    const Bytes ciphertext =
        record.body.subspan(explicit_nonce_octets, record.body.size() - beside);
    const std::size_t most = most_message + (record.id.empty() ? 0 : 1);
    if (ciphertext.size() > most || out.size() < ciphertext.size()) return std::nullopt;
    const Nonce nonce = nonce_of(key, record.body.first(explicit_nonce_octets));
    const Readable readable{record.type, epoch_and_number(1, record.number), record.id,
                            ciphertext.size()};
    const MutableBytes inner = out.first(ciphertext.size());
    const Bytes tag = record.body.last(tag_octets(suite));
    std::ranges::copy(ciphertext, inner.begin());
    const bool is_opened =
        suite == Suite::aes_128_ccm_8
            ? protection::ScheduledCcm::of(key.key).open(nonce, readable.octets(), inner, tag)
            : open_gcm(opening_.get(), key, nonce, readable.octets(), inner, tag);
    if (!is_opened) return std::nullopt;
    if (record.id.empty()) return Opened{record.type, inner.size()};
    return without_padding(inner);
}

}  // namespace romano::dtls
