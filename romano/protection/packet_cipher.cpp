#include "romano/protection/packet_cipher.h"

#include <algorithm>

#include "romano/protection/ccm.h"
#include "romano/protection/sha256.h"

namespace romano::protection {

Nonce nonce_of(Bytes header) {
    Sha256 hash;
    hash.add(header);
    const Sha256::Digest digest = hash.finish();
    Nonce nonce;
    std::copy_n(digest.begin(), nonce.size(), nonce.begin());
    return nonce;
}

void seal(const Key& key, Bytes header, MutableBytes message, MutableBytes tag) {
    Ccm{key, nonce_of(header)}.seal(header, message, tag);
}

bool open(const Key& key, Bytes header, MutableBytes message, Bytes tag) {
    return Ccm{key, nonce_of(header)}.open(header, message, tag);
}

}  // namespace romano::protection
