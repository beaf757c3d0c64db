#include "experiments/fleet/shown_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace romano::experiments::shown_text_test {
namespace {

TEST(ShownText, IsCutBetweenTwoLetters) {
    EXPECT_EQ(shown_text("pose"), "pose");
    EXPECT_EQ(shown_text(std::string(120, 'a')), std::string(120, 'a'));
    EXPECT_EQ(shown_text(std::string(61'440, 'a')), std::string(120, 'a') + "… (61440 octets)");
    EXPECT_EQ(shown_text(std::string(119, 'a') + "€€"), std::string(119, 'a') + "… (125 octets)");
    const std::string no_utf8(200, '\x80');
    EXPECT_LT(shown_text(no_utf8).size(), 150U);
}

TEST(ShownText, IsAMessageInWordsATextOrOctets) {
    const std::uint8_t beat[] = {0x0A, 10, 'a', 'b', 'c', 'd', '1', '2', '3', '4'};
    EXPECT_EQ(shown_data("common", beat), "heartbeat sender=abcd1234");
    EXPECT_EQ(shown_data("a", as_octets("<b>x</b>")), "<b>x</b>");
    const std::uint8_t octets[] = {0xFF, 0x00};
    EXPECT_EQ(shown_data("a", octets), "ff00");
    EXPECT_THAT(shown_data("a", as_octets(std::string(500, '\x01'))),
                ::testing::EndsWith("0101… (500 octets)"));
}

}  // namespace
}  // namespace romano::experiments::shown_text_test
