#include "overlay/link/hello.h"

#include <openssl/crypto.h>
#include <openssl/evp.h>
#include <openssl/hmac.h>
#include <openssl/rand.h>

#include <algorithm>
#include <stdexcept>

namespace romano::link {
namespace {

constexpr std::array<std::uint8_t, 5> opening = {'R', 'L', 'N', 'K', 2};
constexpr std::size_t proof_at = 53;

void put(MutableBytes octets, std::uint64_t value) {
    for (std::size_t i = 8; i-- > 0; value >>= 8U) {
        octets[i] = static_cast<std::uint8_t>(value & 0xFFU);
    }
}

std::uint64_t get(Bytes octets) {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < 8; ++i) value = (value << 8U) | octets[i];
    return value;
}

void put(MutableBytes octets, const broker::LogId& id) {
    put(octets.first(8), static_cast<std::uint64_t>(id.broker));
    put(octets.subspan(8, 8), id.incarnation);
}

broker::LogId get_id(Bytes octets) {
    return {broker::BrokerId{get(octets.first(8))}, get(octets.subspan(8, 8))};
}

std::array<std::uint8_t, 16> proof_of(Bytes octets, const Secret& secret) {
    std::array<std::uint8_t, EVP_MAX_MD_SIZE> digest{};
    const Bytes said = octets.first(proof_at);
    if (HMAC(EVP_sha256(), secret.data(), static_cast<int>(secret.size()), said.data(), said.size(),
             digest.data(), nullptr) == nullptr) {
        throw std::runtime_error("libcrypto has no HMAC-SHA-256");
    }
    std::array<std::uint8_t, 16> out{};
    std::copy_n(digest.begin(), out.size(), out.begin());
    return out;
}

}  // namespace

std::array<std::uint8_t, Hello::octets> encode(const Hello& hello, const Secret& secret) {
    std::array<std::uint8_t, Hello::octets> out{};
    std::ranges::copy(opening, out.begin());
    put(MutableBytes{out}.subspan(5, 16), hello.from);
    put(MutableBytes{out}.subspan(21, 16), hello.to);
    std::ranges::copy(hello.nonce, out.begin() + 37);
    std::ranges::copy(proof_of(out, secret), out.begin() + proof_at);
    return out;
}

std::optional<Hello> decode(Bytes octets, const Secret& secret) {
    if (octets.size() != Hello::octets) return std::nullopt;
    if (!std::ranges::equal(octets.first(opening.size()), opening)) return std::nullopt;
    const auto proof = proof_of(octets, secret);
    if (CRYPTO_memcmp(proof.data(), octets.data() + proof_at, proof.size()) != 0) {
        return std::nullopt;
    }
    Hello out{get_id(octets.subspan(5, 16)), get_id(octets.subspan(21, 16)), {}};
    std::ranges::copy(octets.subspan(37, out.nonce.size()), out.nonce.begin());
    return out;
}

std::array<std::uint8_t, 16> sixteen_random_octets() {
    std::array<std::uint8_t, 16> out{};
    if (RAND_bytes(out.data(), static_cast<int>(out.size())) != 1) {
        throw std::runtime_error("libcrypto has no random numbers");
    }
    return out;
}

}  // namespace romano::link
