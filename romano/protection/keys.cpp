#include "romano/protection/keys.h"

#include <algorithm>

#include "romano/protection/sha256.h"

namespace romano::protection {
namespace {

/// RFC 2104, for keys of at most a block.
class Hmac {
public:
    explicit Hmac(Bytes key) {
        std::copy(key.begin(), key.end(), key_.begin());
        add_key(inner_, 0x36);
    }
    void add(Bytes octets) { inner_.add(octets); }
    [[nodiscard]] Sha256::Digest finish() {
        Sha256 outer;
        add_key(outer, 0x5C);
        outer.add(inner_.finish());
        return outer.finish();
    }

private:
    void add_key(Sha256& hash, std::uint8_t pad) const {
        for (const std::uint8_t octet : key_) {
            const std::uint8_t padded = octet ^ pad;
            hash.add({&padded, 1});
        }
    }

    std::array<std::uint8_t, Sha256::block_size> key_{};
    Sha256 inner_;
};

Key derived(Bytes secret, std::string_view purpose, std::string_view whose) {
    Key key;
    hkdf_sha256(secret, {}, purpose, as_octets(whose), key);
    return key;
}

}  // namespace

void hkdf_sha256(Bytes secret, Bytes salt, std::string_view purpose, Bytes whose,
                 MutableBytes out) {
    Hmac extract{salt};
    extract.add(secret);
    const Sha256::Digest extracted = extract.finish();
    Sha256::Digest last;
    for (std::uint8_t number = 1; !out.empty(); ++number) {
        Hmac expand{extracted};
        if (number > 1) expand.add(last);
        expand.add(as_octets(purpose));
        expand.add(whose);
        expand.add({&number, 1});
        last = expand.finish();
        const std::size_t size = std::min(out.size(), last.size());
        std::copy_n(last.begin(), size, out.begin());
        out = out.subspan(size);
    }
}

RobotKey session_key(const OperatorKey& person, std::string_view client_id) {
    return {derived(person.octets, "ROMANO session ", client_id)};
}

DirectionKeys direction_keys(const RobotKey& robot) {
    return {.to_broker = derived(robot.octets, "ROMANO to broker", {}),
            .to_robot = derived(robot.octets, "ROMANO to robot", {})};
}

Key pre_shared_key(const RobotKey& client) {
    return derived(client.octets, "ROMANO DTLS PSK", {});
}

}  // namespace romano::protection
