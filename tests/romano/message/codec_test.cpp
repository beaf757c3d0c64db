#include "romano/message/codec.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "romano/base/random.h"

namespace romano::message::codec_test {
namespace {

using Octets = std::vector<std::uint8_t>;

Octets operator+(Octets head, std::string_view tail) {
    head.insert(head.end(), tail.begin(), tail.end());
    return head;
}

template <typename T>
T decoded(const Octets& octets) {
    const auto message = decode(octets);
    EXPECT_TRUE(message.has_value());
    EXPECT_TRUE(std::holds_alternative<T>(*message));
    return std::get<T>(*message);
}

Malformed reason(const Octets& octets) {
    const auto message = decode(octets);
    EXPECT_FALSE(message.has_value());
    return message.error();
}

Octets encoded(const Message& message) {
    Octets out(max_message);
    out.resize(encode(message, out));
    return out;
}

const RomanoId abcd1234 = *RomanoId::parse("abcd1234");

TEST(RomanoId, IsTheLastEightDigitsOfTheIpv6AddressWrittenOutInFull) {
    // fe80::212:4b00:abcd:1234 and an address whose last groups have leading zeros
    const std::array<std::uint8_t, 16> address{0xfe, 0x80, 0,    0, 0,    0,    0,    0,
                                               2,    0x12, 0x4b, 0, 0xab, 0xcd, 0x12, 0x34};
    EXPECT_EQ(RomanoId::from_ipv6(address).text(), "abcd1234");
    const std::array<std::uint8_t, 16> small{0xfe, 0x80, 0, 0, 0, 0,    0, 0,
                                             0,    0,    0, 0, 0, 0x0d, 0, 1};
    EXPECT_EQ(RomanoId::from_ipv6(small).text(), "000d0001");
}

TEST(RomanoId, IsEightLowerCaseHexadecimalDigits) {
    for (const char* bad : {"", "abcd123", "abcd12345", "ABCD1234", "abcd123g", "abcd 123"}) {
        EXPECT_FALSE(RomanoId::parse(bad).has_value()) << bad;
    }
}

TEST(Decode, NormalDataMayHoldAnything) {
    EXPECT_TRUE(decoded<NormalData>({0x00, 0x02}).data.empty());
    EXPECT_EQ(as_text(decoded<NormalData>(Octets{0x00, 0x05} + "x=1").data), "x=1");
}

TEST(Decode, SubscribeAndUnsubscribeNameATopic) {
    EXPECT_EQ(decoded<MqttSubscribe>(Octets{0x01, 0x06} + "line").topic, "line");
    EXPECT_EQ(decoded<MqttUnsubscribe>(Octets{0x09, 0x06} + "line").topic, "line");
    EXPECT_EQ(reason({0x01, 0x02}), Malformed::size);
    EXPECT_EQ(reason({0x09, 0x02}), Malformed::size);
}

TEST(Decode, PublishRequestMarksTheTopicsLastOctetByItsIndex) {
    // octet 2 = 6: the topic is octets 3 to 6
    const Octets octets = Octets{0x02, 0x09, 0x06} + "line" + "ir";
    EXPECT_EQ(decoded<MqttPublishRequest>(octets).topic, "line");
    EXPECT_EQ(as_text(decoded<MqttPublishRequest>(octets).kind_of_data), "ir");
    EXPECT_TRUE(
        decoded<MqttPublishRequest>(Octets{0x02, 0x07, 0x06} + "line").kind_of_data.empty());
    EXPECT_EQ(reason({0x02, 0x02}), Malformed::size);
    EXPECT_EQ(reason({0x02, 0x03, 0x02}), Malformed::size);
    EXPECT_EQ(reason(Octets{0x02, 0x07, 0x02} + "line"), Malformed::value)
        << "a topic has an octet";
    EXPECT_EQ(reason(Octets{0x02, 0x07, 0x07} + "line"), Malformed::value) << "beyond the end";
}

TEST(Decode, ConnectedNodesAreWholeIdsAndFewerThan31EndTheList) {
    const Octets two = Octets{0x03, 18} + "abcd12340433ed81";
    EXPECT_EQ(decoded<ConnectedNodes>(two).count(), 2U);
    EXPECT_EQ(decoded<ConnectedNodes>(two).at(1).text(), "0433ed81");
    EXPECT_TRUE(decoded<ConnectedNodes>({0x03, 0x02}).ends_the_list());
    Octets full{0x03, 250};
    for (int i = 0; i < 31; ++i) full = full + "abcd1234";
    EXPECT_FALSE(decoded<ConnectedNodes>(full).ends_the_list());
    EXPECT_EQ(reason(Octets{0x03, 0x09} + "abcd123"), Malformed::size);
    EXPECT_EQ(reason(Octets{0x03, 0x0A} + "ABCD1234"), Malformed::value);
}

TEST(Decode, MessagesThatCarryAnIdCarryNothingElse) {
    EXPECT_EQ(decoded<RequestConnectedNodes>(Octets{0x04, 0x0A} + "abcd1234").asker, abcd1234);
    EXPECT_EQ(decoded<Heartbeat>(Octets{0x0A, 0x0A} + "abcd1234").sender, abcd1234);
    EXPECT_EQ(decoded<ConnectionRequest>(Octets{0x0B, 0x0A} + "abcd1234").sender, abcd1234);
    for (const std::uint8_t type : Octets{0x04, 0x0A, 0x0B}) {
        EXPECT_EQ(reason({type, 0x02}), Malformed::size);
        EXPECT_EQ(reason(Octets{type, 0x0B} + "abcd12345"), Malformed::size);
        EXPECT_EQ(reason(Octets{type, 0x0A} + "abcd123x"), Malformed::value);
    }
}

TEST(Decode, RssiIsSignedDbm) {
    Octets octets = Octets{0x05, 0x0B} + "abcd1234";
    octets.push_back(0xCE);
    EXPECT_EQ(decoded<RssiReport>(octets).rssi_dbm, -50);
    EXPECT_EQ(decoded<RssiReport>(octets).heard, abcd1234);
}

TEST(Decode, StandardMovementsHaveOneU32) {
    const Octets front_100_mm{0x07, 0x08, 0x00, 0x00, 0x00, 0x00, 0x00, 0x64};
    EXPECT_EQ(decoded<MovementControl>(front_100_mm).type, MovementType::front);
    EXPECT_EQ(amount_of(decoded<MovementControl>(front_100_mm)), 100U);
    EXPECT_EQ(reason({0x07, 0x07, 0x00, 0x05, 0x00, 0x00, 0x64}), Malformed::size);
    EXPECT_EQ(reason({0x07, 0x08, 0x00, 0x06, 0x00, 0x00, 0x00, 0x64}), Malformed::value)
        << "reserved";
    EXPECT_EQ(reason({0x07, 0x04, 0x7F, 0xFF}), Malformed::value) << "reserved";
    EXPECT_EQ(reason({0x07, 0x03, 0x00}), Malformed::size);
    const Octets own{0x07, 0x05, 0x80, 0x00, 0x2A};
    EXPECT_EQ(decoded<MovementControl>(own).arguments.size(), 1U);
    EXPECT_FALSE(amount_of(decoded<MovementControl>(own)).has_value());
}

TEST(Decode, SensorValuesHaveTheSizeOfTheirType) {
    EXPECT_EQ(decoded<SensorData>({0x06, 0x06, 0x00, 0x04, 0x12, 0x34}).type, SensorType::battery);
    EXPECT_EQ(reason({0x06, 0x05, 0x00, 0x04, 0x12}), Malformed::size);
    EXPECT_EQ(reason({0x06, 0x04, 0x00, 0x06}), Malformed::value) << "reserved";
    EXPECT_EQ(decoded<SensorData>({0x06, 0x05, 0x80, 0x01, 0x12}).value.size(), 1U);
}

TEST(Decode, AcknowledgementAndUdpTriggersAreBareHeaders) {
    decoded<ConnectionAck>({0x0C, 0x02});
    decoded<UdpSendReq>({0x11, 0x02});
    decoded<UdpSendGo>({0x12, 0x02});
    EXPECT_EQ(reason({0x0C, 0x03, 0x00}), Malformed::size);
}

TEST(Decode, TypesFrom0x13AreTheApplicationsAndThoseBelowAreReserved) {
    EXPECT_EQ(decoded<ApplicationData>({0x13, 0x03, 0x2A}).type, 0x13);
    EXPECT_EQ(decoded<ApplicationData>({0xFF, 0x02}).type, 0xFF);
    for (const std::uint8_t type : Octets{0x0D, 0x0E, 0x0F, 0x10}) {
        EXPECT_EQ(reason({type, 0x02}), Malformed::reserved_type);
    }
}

TEST(Decode, TheLengthOctetMustBeTheReceivedSize) {
    EXPECT_EQ(reason({}), Malformed::header);
    EXPECT_EQ(reason({0x0C}), Malformed::header);
    EXPECT_EQ(reason({0x0C, 0x00}), Malformed::length);
    EXPECT_EQ(reason({0x0C, 0x03}), Malformed::length);
    EXPECT_EQ(reason({0x00, 0x02, 0x00}), Malformed::length);
    EXPECT_EQ(reason(Octets(300, 0x00)), Malformed::length);
}

TEST(Encode, WritesWhatDecodes) {
    EXPECT_EQ(encoded(ConnectionAck{}), (Octets{0x0C, 0x02}));
    EXPECT_EQ(encoded(MqttPublishRequest{"line", as_octets("ir")}),
              Octets({0x02, 0x09, 0x06}) + "lineir");
    EXPECT_EQ(encoded(RssiReport{abcd1234, -50}), (Octets{0x05, 0x0B} + "abcd1234") + "\xCE");
    const Octets amount{0, 0, 0, 100};
    EXPECT_EQ(encoded(MovementControl{MovementType::back, amount}),
              (Octets{0x07, 0x08, 0, 1, 0, 0, 0, 100}));
}

TEST(Encode, RefusesWhatWouldNotDecodeOrFit) {
    const Octets long_data(254);
    EXPECT_TRUE(encoded(NormalData{long_data}).empty());
    EXPECT_EQ(encoded(NormalData{Bytes{long_data}.first(253)}).size(), 255U);
    EXPECT_TRUE(encoded(MqttSubscribe{""}).empty());
    EXPECT_TRUE(encoded(ApplicationData{0x07, {}}).empty());
    EXPECT_TRUE(encoded(MovementControl{MovementType{0x0006}, {}}).empty());
    Octets small(3);
    EXPECT_EQ(encode(NormalData{as_octets("ab")}, small), 0U);
}

TEST(Decode, AnyOctetsGiveAMessageThatEncodesToThemOrAReason) {
    const std::uint64_t seed = 20170801;
    Random random(seed);
    int messages = 0;
    for (int round = 0; round < 200'000; ++round) {
        Octets octets(random.below(40));
        for (auto& octet : octets) octet = static_cast<std::uint8_t>(random.below(256));
        if (octets.size() >= 2 && random.happens(900'000)) {
            octets[0] = static_cast<std::uint8_t>(random.below(0x15));
            octets[1] = static_cast<std::uint8_t>(octets.size());
        }
        if (const auto message = decode(octets)) {
            ++messages;
            ASSERT_EQ(encoded(*message), octets) << "seed " << seed << " round " << round;
        }
    }
    EXPECT_GT(messages, 10'000);
}

}  // namespace
}  // namespace romano::message::codec_test
