// MQTT-SN 1.2 section 6.1e: a client answers another one's search when no gateway does.

#include "romano/client/search_answer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <vector>

#include "romano/mqttsn/codec.h"

namespace romano::client::search_answer_test {
namespace {

using namespace mqttsn;
using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;
using Octets = std::vector<std::uint8_t>;

class SearchAnswerTest : public testing::Test {
protected:
    void hears(const Message& message) {
        Octets octets(encoded_size(message));
        EXPECT_EQ(encode(message, octets), octets.size());
        const Endpoint gateway{
            .address = {10, 0, 0, 1}, .port = 10000, .family = Endpoint::Family::ipv4};
        discovery.on_datagram(now, gateway, octets);
        answer.on_datagram(now, octets);
    }
    /// What it sends when it wants to be called within `time`.
    Octets after(Duration time) {
        const Instant end = now + time;
        Octets octets(SearchAnswer::largest_datagram);
        now = std::min(end, answer.next_wakeup());
        octets.resize(answer.on_tick(now, octets));
        now = end;
        return octets;
    }

    Discovery discovery{{}, 1};
    SearchAnswer answer{discovery, 2};
    Instant now{};
};

TEST_F(SearchAnswerTest, ComesWithinTgwinfoWhenNoGatewayAnswers) {
    hears(Advertise{7, 900});
    hears(Searchgw{0});
    EXPECT_THAT(after(5s), ElementsAre(0x09, 0x02, 7, 10, 0, 0, 1, 0x27, 0x10));
    EXPECT_THAT(after(600s), IsEmpty());
}

TEST_F(SearchAnswerTest, IsLeftToWhoeverIsFaster) {
    hears(Advertise{7, 900});
    hears(Searchgw{0});
    hears(Gwinfo{7, {}});
    EXPECT_THAT(after(60s), IsEmpty());
}

TEST_F(SearchAnswerTest, IsNoneWithoutAGateway) {
    hears(Searchgw{0});
    EXPECT_EQ(answer.next_wakeup(), never);
}

}  // namespace
}  // namespace romano::client::search_answer_test
