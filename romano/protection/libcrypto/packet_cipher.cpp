#include "romano/protection/packet_cipher.h"

#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <memory>

#include "romano/protection/libcrypto/scheduled_ccm.h"

namespace romano::protection {
namespace {

struct Free {
    void operator()(EVP_MD_CTX* context) const { EVP_MD_CTX_free(context); }
    void operator()(EVP_MD* digest) const { EVP_MD_free(digest); }
};

/// Made once a thread: that takes longer than a packet.
struct Sha256ByLibcrypto {
    std::unique_ptr<EVP_MD, Free> digest{EVP_MD_fetch(nullptr, "SHA256", nullptr)};
    std::unique_ptr<EVP_MD_CTX, Free> context{EVP_MD_CTX_new()};
};

}  // namespace

Nonce nonce_of(Bytes header) {
    thread_local const Sha256ByLibcrypto sha256;
    std::array<std::uint8_t, 32> digest{};
    const bool is_done =
        EVP_DigestInit_ex2(sha256.context.get(), sha256.digest.get(), nullptr) == 1 &&
        EVP_DigestUpdate(sha256.context.get(), header.data(), header.size()) == 1 &&
        EVP_DigestFinal_ex(sha256.context.get(), digest.data(), nullptr) == 1;
    if (!is_done) std::abort();  // want of memory: no packet may leave with the nonce of another
    Nonce nonce;
    std::copy_n(digest.begin(), nonce.size(), nonce.begin());
    return nonce;
}

void seal(const Key& key, Bytes header, MutableBytes message, MutableBytes tag) {
    ScheduledCcm::of(key).seal(nonce_of(header), header, message, tag);
}

bool open(const Key& key, Bytes header, MutableBytes message, Bytes tag) {
    return ScheduledCcm::of(key).open(nonce_of(header), header, message, tag);
}

}  // namespace romano::protection
