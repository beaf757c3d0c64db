// Any octets are a message or the reason why not; a message goes both ways without a change.

#include "romano/mqttsn/codec.h"

#include <cstddef>
#include <cstdint>
#include <vector>

#include "tests/fuzz/require.h"

using namespace romano;
using namespace romano::mqttsn;

namespace {

using Octets = std::vector<std::uint8_t>;

Octets encoded(const Message& message) {
    Octets octets(encoded_size(message));
    REQUIRE(encode(message, octets) == octets.size());
    if (!octets.empty()) {
        Octets too_small(octets.size() - 1);
        REQUIRE(encode(message, too_small) == 0);
    }
    return octets;
}

}  // namespace

// NOLINTNEXTLINE(readability-identifier-naming): the name that libFuzzer calls
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const Bytes datagram{data, size};
    const auto message = decode(datagram);
    if (!message) {
        REQUIRE(static_cast<std::size_t>(message.error()) < malformed_kinds);
        return 0;
    }
    REQUIRE(name_of(type_of(*message)) != "RESERVED");
    const Octets octets = encoded(*message);
    REQUIRE(octets.size() <= size);  // the short form, the empty form: never longer
    const auto again = decode(octets);
    REQUIRE(again.has_value());
    REQUIRE(type_of(*again) == type_of(*message));
    REQUIRE(encoded(*again) == octets);
    return 0;
}
