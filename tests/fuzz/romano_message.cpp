// ROMANO messages: any octets are a message or the reason why not, and a message goes both ways;
// and a node hears any of them without harm to its mailbox.

#include <array>

#include "romano/message/codec.h"
#include "romano/node/mailbox.h"
#include "tests/fuzz/require.h"

using namespace romano;

// NOLINTNEXTLINE(readability-identifier-naming): the name that libFuzzer calls
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const auto message = message::decode({data, size});
    if (!message) return 0;
    std::array<std::uint8_t, message::max_message> octets{};
    REQUIRE(message::encode(*message, octets) == size);
    REQUIRE(std::equal(data, data + size, octets.begin()));
    if (const auto* movement = std::get_if<message::MovementControl>(&*message)) {
        romano_mailbox box{};
        const auto arguments = movement->arguments;
        const bool taken =
            romano_mailbox_put(&box, static_cast<std::uint16_t>(movement->type), arguments.data(),
                               static_cast<std::uint32_t>(arguments.size()));
        REQUIRE(taken == (arguments.size() <= ROMANO_COMMAND_ARGUMENTS));
    }
    return 0;
}
