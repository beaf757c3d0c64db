#include "broker/dtls/wrapped_keys.h"

#include <algorithm>

#include "romano/protection/ccm.h"

namespace romano::dtls {
namespace {

constexpr std::size_t tag_size = 8;
// The key is that of one association and seals one message.
constexpr std::array<std::uint8_t, 13> nonce{};

protection::Key wrapping_key(const protection::RobotKey& client, AssociationId id) {
    std::array<std::uint8_t, 8> whose{};
    put_be64(whose, 0, static_cast<std::uint64_t>(id));
    protection::Key key;
    protection::hkdf_sha256(client.octets, {}, "ROMANO DTLS association ", whose, key);
    return key;
}

std::uint8_t* put(std::uint8_t* at, const WriteKey& key) {
    return std::copy(key.salt.begin(), key.salt.end(),
                     std::copy(key.key.begin(), key.key.end(), at));
}

const std::uint8_t* take(const std::uint8_t* at, WriteKey& key) {
    std::copy_n(at, key.key.size(), key.key.begin());
    std::copy_n(at + key.key.size(), key.salt.size(), key.salt.begin());
    return at + key.key.size() + key.salt.size();
}

}  // namespace

WrappedKeys wrap(const RecordKeys& keys, const protection::RobotKey& client,
                 std::string_view client_id, AssociationId id) {
    WrappedKeys out{};
    out[0] = static_cast<std::uint8_t>(keys.suite);
    put(put(out.data() + 1, keys.client), keys.server);
    const protection::Key key = wrapping_key(client, id);
    const MutableBytes all{out};
    protection::Ccm(key, nonce)
        .seal(as_octets(client_id), all.first(wrapped_octets - tag_size), all.last(tag_size));
    return out;
}

std::optional<RecordKeys> unwrap(Bytes wrapped, const protection::RobotKey& client,
                                 std::string_view client_id, AssociationId id) {
    if (wrapped.size() != wrapped_octets) return std::nullopt;
    WrappedKeys copy{};
    std::copy(wrapped.begin(), wrapped.end(), copy.begin());
    const protection::Key key = wrapping_key(client, id);
    const MutableBytes all{copy};
    const MutableBytes message = all.first(wrapped_octets - tag_size);
    if (!protection::Ccm(key, nonce).open(as_octets(client_id), message, all.last(tag_size)) ||
        message[0] >= known_suites) {
        return std::nullopt;
    }
    RecordKeys keys;
    keys.suite = Suite{message[0]};
    take(take(message.data() + 1, keys.client), keys.server);
    return keys;
}

}  // namespace romano::dtls
