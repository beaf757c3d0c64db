// The octets of each message of a loop, as romano/control/README.md has them.
#include "romano/control/messages.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <string>
#include <vector>

#include "romano/base/random.h"
#include "romano/message/codec.h"

namespace romano::control::messages_test {
namespace {

using Octets = std::vector<std::uint8_t>;

const RomanoId plant_id = *RomanoId::parse("abcd1234");
const RomanoId other_id = *RomanoId::parse("00000002");

Octets octets(const std::string& text) {
    return {text.begin(), text.end()};
}
Octets joined(std::initializer_list<Octets> parts) {
    Octets all;
    for (const Octets& part : parts) all.insert(all.end(), part.begin(), part.end());
    return all;
}

template <typename M>
Octets encoded(const M& message) {
    std::array<std::uint8_t, 255> room{};
    const std::size_t size = encode(message, room);
    return {room.begin(), room.begin() + static_cast<std::ptrdiff_t>(size)};
}

const Octets parameters = {9, 8, 7};
const Open some_open{.channel = Channel{3},
                     .ticket = Session{0x01020304},
                     .asker = other_id,
                     .controller = plant_id,
                     .law = Law{0x0506},
                     .period_ms = 20,
                     .deadline_ms = 300,
                     .lease_s = 10,
                     .fallback = Fallback::hold,
                     .ends_then = true,
                     .parameters = parameters};

Octets octets_of_open() {
    return joined({{0xC0, 36, 2, 3, 1, 2, 3, 4},
                   octets("00000002abcd1234"),
                   {5, 6, 0, 20, 1, 44, 0, 10, 0x81, 9, 8, 7}});
}

std::vector<Octets> one_of_each() {
    return {
        encoded(Ask{Channel{1}, plant_id}),
        octets_of_open(),
        encoded(Renew{Session{1}, plant_id}),
        encoded(End{Session{1}, plant_id}),
        encoded(Report{.channel = Channel{1},
                       .session = Session{1},
                       .plant = plant_id,
                       .controller = other_id,
                       .state = State::waiting,
                       .reason = Reason::busy,
                       .counters = {},
                       .ages = {}}),
        encoded(Invite{Session{1}, plant_id, Channel{1}, Law{2}, 3, 4, {}}),
        encoded(Answer{Session{1}, Reason::none}),
        encoded(Sample{Session{1}, 2, 3, Sample::no_age, {}}),
        encoded(Command{Session{1}, 2, 3, {}}),
        encoded(Bye{Session{1}, Reason::lease_over}),
    };
}

TEST(ControlMessage, HasTheOctetsOfTheTable) {
    EXPECT_EQ(encoded(Ask{Channel{7}, plant_id}), joined({{0xC0, 12, 1, 7}, octets("abcd1234")}));
    EXPECT_EQ(encoded(some_open), octets_of_open());
    EXPECT_EQ(encoded(Renew{Session{0xA1A2A3A4}, plant_id}),
              joined({{0xC0, 15, 3, 0xA1, 0xA2, 0xA3, 0xA4}, octets("abcd1234")}));
    EXPECT_EQ(encoded(End{Session{0xA1A2A3A4}, plant_id}),
              joined({{0xC0, 15, 4, 0xA1, 0xA2, 0xA3, 0xA4}, octets("abcd1234")}));
    const Report report{.channel = Channel{7},
                        .session = Session{0x01020304},
                        .plant = plant_id,
                        .controller = other_id,
                        .state = State::controlled,
                        .reason = Reason::busy,
                        .counters = {1, 2, 3, 4, 5, 6},
                        .ages = {7, 8, 9, 10, 0x01020304}};
    Octets numbers;
    for (std::uint8_t n = 1; n <= 10; ++n) numbers.insert(numbers.end(), {0, 0, 0, n});
    EXPECT_EQ(encoded(report), joined({{0xC0, 70, 5, 7, 1, 2, 3, 4},
                                       octets("abcd123400000002"),
                                       {3, 3},
                                       numbers,
                                       {1, 2, 3, 4}}));
    EXPECT_EQ(
        encoded(
            Invite{Session{0x01020304}, plant_id, Channel{7}, Law{0x0506}, 20, 300, parameters}),
        joined({{0xC0, 25, 6, 1, 2, 3, 4}, octets("abcd1234"), {7, 5, 6, 0, 20, 1, 44, 9, 8, 7}}));
    EXPECT_EQ(encoded(Answer{Session{0x01020304}, Reason::controller_full}),
              (Octets{0xC0, 8, 7, 1, 2, 3, 4, 7}));
    EXPECT_EQ(encoded(Sample{Session{0x01020304}, 0x05060708, 0x090A0B0C, 0x0D0E, parameters}),
              (Octets{0xC0, 20, 8, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 9, 8, 7}));
    EXPECT_EQ(encoded(Command{Session{0x01020304}, 0x05060708, 0x090A0B0C, parameters}),
              (Octets{0xC0, 18, 9, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 9, 8, 7}));
    EXPECT_EQ(encoded(Bye{Session{0x01020304}, Reason::lease_over}),
              (Octets{0xC0, 8, 10, 1, 2, 3, 4, 10}));
}

TEST(ControlMessage, IsARomanoMessageOfTheApplicationsOwn) {
    for (const Octets& message : one_of_each()) EXPECT_FALSE(message::flaw_of(message));
}

TEST(ControlMessage, DecodesToWhatWasEncoded) {
    const Octets octets = octets_of_open();
    const auto message = decode(octets);
    ASSERT_TRUE(message);
    const auto* open = std::get_if<Open>(&*message);
    ASSERT_NE(open, nullptr);
    EXPECT_EQ(open->fallback, Fallback::hold);
    EXPECT_TRUE(open->ends_then);
    for (const Octets& each : one_of_each()) {
        const auto decoded = decode(each);
        ASSERT_TRUE(decoded) << testing::PrintToString(each);
        EXPECT_EQ(std::visit([](const auto& m) { return encoded(m); }, *decoded), each);
    }
}

TEST(ControlMessage, OfAnotherLengthIsNone) {
    const std::size_t with_rest[] = {2, 6, 8, 9};  // kinds that end in octets of any number
    for (const Octets& whole : one_of_each()) {
        for (std::size_t size = 0; size < whole.size(); ++size) {
            Octets cut{whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)};
            EXPECT_FALSE(decode(cut));
            if (size < 3) continue;
            cut[1] = static_cast<std::uint8_t>(size);  // and says so
            const bool is_in_the_rest = cut[2] == 2 && size >= 33;
            EXPECT_EQ(decode(cut).has_value(), is_in_the_rest) << int{cut[2]} << " " << size;
        }
        Octets longer = whole;
        longer.push_back(0);
        EXPECT_FALSE(decode(longer));
        ++longer[1];
        EXPECT_EQ(decode(longer).has_value(),
                  std::count(std::begin(with_rest), std::end(with_rest), longer[2]) == 1);
    }
}

TEST(ControlMessage, WithAValueThatMayNotBeIsNone) {
    const auto with = [](Octets message, std::size_t at, std::uint8_t value) {
        message[at] = value;
        return message;
    };
    const auto all = one_of_each();
    EXPECT_FALSE(decode(with(all[0], 0, 0x13)));
    EXPECT_FALSE(decode(with(all[0], 2, 0)));
    EXPECT_FALSE(decode(with(all[0], 2, 11)));
    EXPECT_FALSE(decode(with(all[0], 4, 'A')));    // no id
    EXPECT_FALSE(decode(with(all[1], 32, 3)));     // fallback
    EXPECT_FALSE(decode(with(all[1], 32, 0x40)));  //
    EXPECT_FALSE(decode(with(all[4], 24, 4)));     // state
    EXPECT_FALSE(decode(with(all[4], 25, 14)));    // reason
    EXPECT_FALSE(decode(with(all[6], 7, 14)));     //
    EXPECT_FALSE(decode(with(all[9], 7, 0xFF)));   //
}

TEST(ControlMessage, WithTooManyOctetsIsNotMade) {
    const Octets much(most_value + 1);
    EXPECT_EQ(encoded(Sample{Session{1}, 2, 3, 4, Bytes{much}.first(most_value)}).size(),
              largest_message);
    EXPECT_TRUE(encoded(Sample{Session{1}, 2, 3, 4, much}).empty());
    EXPECT_TRUE(encoded(Command{Session{1}, 2, 3, much}).empty());
    Open open = some_open;
    open.parameters = Bytes{much}.first(most_parameters + 1);
    EXPECT_TRUE(encoded(open).empty());
    std::array<std::uint8_t, 11> little{};
    EXPECT_EQ(encode(Ask{Channel{7}, plant_id}, little), 0U);
}

TEST(ControlMessage, AnyOctetsAreAMessageOrNone) {
    Random random{1};
    for (int i = 0; i < 200'000; ++i) {
        std::array<std::uint8_t, 100> room;
        const std::size_t size = 3 + random.below(90);
        for (std::size_t at = 0; at < size; ++at) {
            room[at] = static_cast<std::uint8_t>(random.next());
        }
        room[0] = data_type;
        room[1] = static_cast<std::uint8_t>(size);
        room[2] = static_cast<std::uint8_t>(random.below(12));
        const auto message = decode(Bytes{room}.first(size));
        if (!message) continue;
        const Octets again = std::visit([](const auto& m) { return encoded(m); }, *message);
        EXPECT_EQ(again, Octets(room.begin(), room.begin() + static_cast<std::ptrdiff_t>(size)));
    }
}

}  // namespace
}  // namespace romano::control::messages_test
