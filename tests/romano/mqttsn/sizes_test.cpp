// MQTT-SN 1.2 section 5.4: which sizes each message can have; everything else is dropped.

#include <gtest/gtest.h>

#include <cstdint>
#include <functional>
#include <vector>

#include "romano/mqttsn/codec.h"

namespace romano::mqttsn::sizes_test {
namespace {

using Octets = std::vector<std::uint8_t>;

struct Sizes {
    MsgType type;
    std::function<bool(std::size_t)> possible;  // of the whole message in the short form
};

auto exactly(std::size_t size) {
    return [size](std::size_t s) { return s == size; };
}
auto at_least(std::size_t size) {
    return [size](std::size_t s) { return s >= size; };
}

const std::vector<Sizes>& table() {
    static const std::vector<Sizes> sizes = {
        {MsgType::advertise, exactly(5)},
        {MsgType::searchgw, exactly(3)},
        {MsgType::gwinfo, at_least(3)},
        {MsgType::connect, at_least(6)},
        {MsgType::connack, exactly(3)},
        {MsgType::willtopicreq, exactly(2)},
        {MsgType::willtopic, at_least(2)},
        {MsgType::willmsgreq, exactly(2)},
        {MsgType::willmsg, at_least(2)},
        {MsgType::register_, at_least(6)},
        {MsgType::regack, exactly(7)},
        {MsgType::publish, at_least(7)},
        {MsgType::puback, exactly(7)},
        {MsgType::pubcomp, exactly(4)},
        {MsgType::pubrec, exactly(4)},
        {MsgType::pubrel, exactly(4)},
        {MsgType::subscribe, at_least(6)},
        {MsgType::suback, exactly(8)},
        {MsgType::unsubscribe, at_least(6)},
        {MsgType::unsuback, exactly(4)},
        {MsgType::pingreq, at_least(2)},
        {MsgType::pingresp, exactly(2)},
        {MsgType::disconnect, [](std::size_t s) { return s == 2 || s == 4; }},
        {MsgType::willtopicupd, at_least(2)},
        {MsgType::willtopicresp, exactly(3)},
        {MsgType::willmsgupd, at_least(2)},
        {MsgType::willmsgresp, exactly(3)},
    };
    return sizes;
}

Octets zeros_of(MsgType type, std::size_t size) {
    Octets octets(size);
    octets[0] = static_cast<std::uint8_t>(size);
    octets[1] = static_cast<std::uint8_t>(type);
    return octets;
}

TEST(Sizes, OnlyThoseOfTheTableAreTaken) {
    for (const Sizes& sizes : table()) {
        for (std::size_t size = 2; size <= 255; ++size) {
            const Octets octets = zeros_of(sizes.type, size);
            const auto message = decode(octets);
            EXPECT_EQ(message.has_value(), sizes.possible(size))
                << name_of(sizes.type) << " of " << size;
            if (message) continue;
            EXPECT_EQ(message.error(), Malformed::size);
        }
    }
}

TEST(Sizes, OnlyThoseOfTheTableAreTakenInTheLongForm) {
    for (const Sizes& sizes : table()) {
        for (std::size_t size = 2; size <= 300; ++size) {
            Octets octets(size + 2);
            octets[0] = 0x01;
            put_be16(octets, 1, static_cast<std::uint16_t>(size + 2));
            octets[3] = static_cast<std::uint8_t>(sizes.type);
            EXPECT_EQ(decode(octets).has_value(), sizes.possible(size))
                << name_of(sizes.type) << " of " << size;
        }
    }
}

TEST(Sizes, EveryTruncationOfADatagramIsDropped) {
    for (const Sizes& sizes : table()) {
        std::size_t size = 2;
        while (!sizes.possible(size)) ++size;
        const Octets whole = zeros_of(sizes.type, sizes.possible(size + 9) ? size + 9 : size);
        for (std::size_t kept = 0; kept < whole.size(); ++kept) {
            // A copy of its own, so that reading behind the end is seen.
            const Octets cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(kept));
            EXPECT_FALSE(decode(cut)) << name_of(sizes.type) << " cut to " << kept;
        }
    }
}

}  // namespace
}  // namespace romano::mqttsn::sizes_test
