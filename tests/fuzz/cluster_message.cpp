// What a peer's sample may hold: any octets are a cluster message or none, and a message goes both
// ways. Inputs are octets as they are, or changes to a message of a random kind: those go deeper.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "overlay/dds/body_codec.h"
#include "romano/base/random.h"
#include "tests/fuzz/require.h"
#include "tests/fuzz/script.h"
#include "tests/overlay/dds/random_message.h"

using namespace romano;

namespace {

void hear(dds::BodyCodec& codec, Bytes body) {
    const auto message = codec.decode(body);
    if (!message) return;
    const Bytes again = codec.encode(*message);
    const std::vector<std::uint8_t> copy{again.begin(), again.end()};
    REQUIRE(codec.decode(copy).has_value());
}

/// Each three octets: where, and what stands there instead.
std::vector<std::uint8_t> changed(Bytes body, fuzz::Script& script) {
    std::vector<std::uint8_t> octets{body.begin(), body.end()};
    while (!script.is_over() && !octets.empty()) {
        const std::size_t at = (std::size_t{script.octet()} << 8U | script.octet()) % octets.size();
        octets[at] = script.octet();
    }
    return octets;
}

}  // namespace

// NOLINTNEXTLINE(readability-identifier-naming): the name that libFuzzer calls
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static dds::BodyCodec codec;
    fuzz::Script script{Bytes{data, size}};
    const std::uint8_t kind = script.octet();
    if (kind >= dds::message_kinds) {
        hear(codec, script.octets(size));
        return 0;
    }
    Random random{script.octet()};
    hear(codec, changed(codec.encode(dds::random_message(kind, random)), script));
    return 0;
}
