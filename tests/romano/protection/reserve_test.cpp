// Numbers are used once, and only below what is stored.

#include "romano/protection/reserve.h"

#include <gtest/gtest.h>

#include "romano/protection/sealer.h"
#include "tests/romano/protection/hex.h"

namespace romano::protection {
namespace {

constexpr std::uint32_t block = numbers_a_block;
constexpr Key key{};

struct Sender {
    explicit Sender(std::uint32_t stored) : reserve(stored) {}
    bool seal() { return sealer.seal(RunId{0}, octets("0216"), room, refusals) != 0; }
    bool refuses_as(Refusal why) {
        const std::uint32_t before = refusals.of(why);
        return !seal() && refusals.of(why) == before + 1;
    }
    void store() {
        if (const auto bound = reserve.to_store()) reserve.on_stored(*bound);
    }

    Reserve reserve;
    Sealer sealer{key, {}, reserve};
    Refusals refusals;
    Octets room = Octets(40);
};

TEST(Reserve, GivesNoNumberBeforeABoundIsStored) {
    Sender sender{0};
    EXPECT_TRUE(sender.refuses_as(Refusal::unstored));
    EXPECT_EQ(sender.reserve.to_store(), 2 * block);
    EXPECT_TRUE(sender.refuses_as(Refusal::unstored));  // asked for is not stored
    sender.store();
    EXPECT_EQ(sender.reserve.to_store(), std::nullopt);
    EXPECT_TRUE(sender.seal());
}

TEST(Reserve, AsksABlockAhead) {
    Sender sender{0};
    sender.store();
    for (std::uint32_t i = 0; i < block - 1; ++i) ASSERT_TRUE(sender.seal());
    EXPECT_EQ(sender.reserve.to_store(), std::nullopt);
    ASSERT_TRUE(sender.seal());
    EXPECT_EQ(sender.reserve.to_store(), 3 * block);
    for (std::uint32_t i = 0; i < block; ++i) ASSERT_TRUE(sender.seal());
    EXPECT_TRUE(sender.refuses_as(Refusal::unstored));
    sender.store();
    EXPECT_TRUE(sender.seal());
}

TEST(Reserve, AsksAStepAheadOfWhoNumbersFast) {
    constexpr std::uint32_t step = 16 * block;
    Reserve reserve{3 * block};
    EXPECT_EQ(reserve.to_store(step), 2 * step);
    reserve.on_stored(2 * step);
    reserve.on_used(step - 2);
    EXPECT_EQ(reserve.to_store(step), std::nullopt);
    reserve.on_used(step - 1);
    EXPECT_EQ(reserve.to_store(step), 3 * step);
    reserve.on_used(max_number - 1);  // and the end is where it was
    EXPECT_EQ(reserve.to_store(step), max_number + 2 * block);
    EXPECT_EQ(reserve.to_store(), max_number + 2 * block);
}

TEST(Reserve, BeginsAtTheStoredBoundAfterARestart) {
    Sender sender{2 * block};
    EXPECT_TRUE(sender.refuses_as(Refusal::unstored));
    sender.store();
    EXPECT_EQ(sender.sealer.next(), 2 * block);
    EXPECT_TRUE(sender.seal());
}

TEST(Reserve, EndsInsteadOfWrapping) {
    Sender sender{max_number - block};
    sender.store();
    EXPECT_EQ(sender.reserve.to_store(), std::nullopt);
    for (std::uint32_t i = 0; i < block; ++i) {
        ASSERT_TRUE(sender.seal()) << i;
        sender.store();
    }
    for (int i = 0; i < 3; ++i) {
        EXPECT_TRUE(sender.refuses_as(Refusal::used_up));
        sender.store();
        sender.sealer.skip_block();
    }
    Sender restarted{max_number};
    restarted.store();
    EXPECT_TRUE(restarted.refuses_as(Refusal::used_up));
}

TEST(Reserve, ASkippedBlockIsUsedByNobody) {
    Sender sender{0};
    sender.store();
    sender.sealer.skip_block();
    EXPECT_EQ(sender.sealer.next(), 0u);  // nothing of it was used: nothing is to be skipped
    ASSERT_TRUE(sender.seal());
    sender.sealer.skip_block();
    EXPECT_EQ(sender.sealer.next(), block);
    EXPECT_EQ((Sealer{key, {}, sender.reserve}.next()), block);
    EXPECT_EQ(sender.reserve.to_store(), 3 * block);
}

TEST(Reserve, ASealerBeginsAboveAllThatEarlierOnesUsed) {
    Sender sender{0};
    sender.store();
    for (int i = 0; i < 5; ++i) ASSERT_TRUE(sender.seal());
    EXPECT_EQ((Sealer{key, {}, sender.reserve}.next()), 5u);
}

TEST(Reserve, ARefusedPacketUsesNoNumber) {
    Sender sender{0};
    sender.store();
    sender.room.resize(29);
    EXPECT_TRUE(sender.refuses_as(Refusal::too_long));
    EXPECT_EQ(sender.sealer.next(), 0u);
}

}  // namespace
}  // namespace romano::protection
