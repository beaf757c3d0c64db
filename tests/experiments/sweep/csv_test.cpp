#include "experiments/sweep/csv.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace romano::experiments::csv_test {
namespace {

using ::testing::ElementsAre;

TEST(Csv, QuotesOnlyFieldsThatNeedIt) {
    EXPECT_EQ(csv_line({"a", "b,c", "say \"no\"", "two\nlines", ""}),
              "a,\"b,c\",\"say \"\"no\"\"\",\"two\nlines\",\n");
}

TEST(Csv, ReadsBackWhatItWrote) {
    const CsvRow row = {"", "plain", "a,b", "\"", "\"\"", "x\ny", " spaces "};
    EXPECT_THAT(parse_csv(csv_line(row) + csv_line({"next"})), ElementsAre(row, CsvRow{"next"}));
}

TEST(Csv, LeavesOutALastRowThatWasCutOff) {
    EXPECT_THAT(parse_csv("a,b\n1,2\n3,"), ElementsAre(CsvRow{"a", "b"}, CsvRow{"1", "2"}));
    EXPECT_THAT(parse_csv("a\n\"half"), ElementsAre(CsvRow{"a"}));
}

TEST(Csv, NumbersReadBackExactly) {
    for (const double number : {0.0, 0.1, 1.0 / 3.0, 1e-9, 123456789.125, -2.5}) {
        EXPECT_EQ(parse_csv_number(csv_number(number)), number);
    }
    EXPECT_EQ(csv_number(20), "20");
    EXPECT_EQ(csv_number(900000), "900000") << "no exponent in a count";
    EXPECT_EQ(parse_csv_number("12x"), std::nullopt);
    EXPECT_EQ(parse_csv_number(""), std::nullopt);
}

}  // namespace
}  // namespace romano::experiments::csv_test
