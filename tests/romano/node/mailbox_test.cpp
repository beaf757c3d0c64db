#include "romano/node/mailbox.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <thread>

extern "C" std::uint32_t front_millimetres_in_c(romano_mailbox* box);

namespace romano::node::mailbox_test {
namespace {

using Amount = std::array<std::uint8_t, 4>;

constexpr Amount amount(std::uint32_t value) {
    return {static_cast<std::uint8_t>(value >> 24U), static_cast<std::uint8_t>(value >> 16U),
            static_cast<std::uint8_t>(value >> 8U), static_cast<std::uint8_t>(value)};
}

bool put(romano_mailbox& box, std::uint16_t type, std::uint32_t value) {
    return romano_mailbox_put(&box, type, amount(value).data(), 4);
}

TEST(Mailbox, GivesCommandsInTheOrderInWhichTheyCame) {
    romano_mailbox box{};
    romano_command command{};
    EXPECT_FALSE(romano_mailbox_get(&box, &command));
    EXPECT_TRUE(put(box, 0, 100));
    EXPECT_TRUE(put(box, 5, 90'000));
    ASSERT_TRUE(romano_mailbox_get(&box, &command));
    EXPECT_EQ(command.type, 0);
    EXPECT_EQ(romano_command_amount(&command), 100U);
    ASSERT_TRUE(romano_mailbox_get(&box, &command));
    EXPECT_EQ(command.type, 5);
    EXPECT_EQ(romano_command_amount(&command), 90'000U);
    EXPECT_FALSE(romano_mailbox_get(&box, &command));
}

TEST(Mailbox, FullRefusesTheNewestAndCountsIt) {
    romano_mailbox box{};
    for (std::uint32_t i = 0; i < ROMANO_MAILBOX_COMMANDS; ++i) EXPECT_TRUE(put(box, 0, i));
    EXPECT_FALSE(put(box, 0, 99));
    EXPECT_EQ(romano_mailbox_refused(&box), 1U);
    romano_command command{};
    ASSERT_TRUE(romano_mailbox_get(&box, &command));
    EXPECT_EQ(romano_command_amount(&command), 0U) << "the oldest is kept";
    EXPECT_TRUE(put(box, 0, 99));
}

TEST(Mailbox, ACommandWithTooManyArgumentsIsRefused) {
    romano_mailbox box{};
    const std::array<std::uint8_t, ROMANO_COMMAND_ARGUMENTS + 1> arguments{};
    EXPECT_FALSE(romano_mailbox_put(&box, 0x8000, arguments.data(), ROMANO_COMMAND_ARGUMENTS + 1));
    EXPECT_TRUE(romano_mailbox_put(&box, 0x8000, arguments.data(), ROMANO_COMMAND_ARGUMENTS));
    EXPECT_EQ(romano_mailbox_refused(&box), 1U);
}

TEST(Mailbox, IsReadFromC) {
    romano_mailbox box{};
    put(box, 0, 100);
    put(box, 4, 7);
    put(box, 0, 23);
    EXPECT_EQ(front_millimetres_in_c(&box), 123U);
}

TEST(Mailbox, OneWriterAndOneReaderNeverLoseOrReorderWhatWasAccepted) {
    romano_mailbox box{};
    constexpr std::uint32_t count = 200'000;
    std::thread writer([&box] {
        for (std::uint32_t i = 0; i < count;) {
            if (put(box, 0, i)) ++i;
        }
    });
    for (std::uint32_t expected = 0; expected < count;) {
        romano_command command{};
        if (!romano_mailbox_get(&box, &command)) continue;
        EXPECT_EQ(romano_command_amount(&command), expected);
        ++expected;
    }
    writer.join();
}

}  // namespace
}  // namespace romano::node::mailbox_test
