// Numbers of records: each once, whichever brokers speak (broker/dtls/README.md, "No number
// twice").

#include "broker/dtls/turn.h"

#include <gtest/gtest.h>

#include "romano/dtls/record/record.h"

namespace romano::dtls::turn_test {
namespace {

TEST(DtlsTurn, LaterGenerationsHaveHigherNumbersWhicheverPlace) {
    const Turn first = Turn{}.next_of(most_places);
    const Turn second = first.next_of(1);
    EXPECT_GT(second.number(0), first.number(most_count - 1));
    EXPECT_GT(first.number(0), std::uint64_t{1} << 24U) << "OpenSSL's own begin at 0";
}

TEST(DtlsTurn, TwoPlacesNeverHaveOneNumber) {
    const Turn one = Turn{}.next_of(3);
    const Turn other = Turn{}.next_of(4);
    EXPECT_EQ(one.generation(), other.generation());
    EXPECT_GT(other.number(0), one.number(most_count - 1));
}

TEST(DtlsTurn, TheLastOneStillFits48Bits) {
    Turn turn;
    unsigned turns = 0;
    for (; !turn.is_last(); ++turns) turn = turn.next_of(most_places);
    EXPECT_EQ(turns, most_generation);
    EXPECT_EQ(turn.number(most_count - 1), most_number);
}

}  // namespace
}  // namespace romano::dtls::turn_test
