// RFC 6750 (Bearer) and RFC 7617 (Basic).

#include "broker/https/token.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "romano/keys/key_error.h"
#include "tests/https_files.h"

namespace romano::https::token_test {
namespace {

using testing::HasSubstr;

struct TokenOfAFile : testing::Test {
    tests::HttpsFiles files;
    Token token{files.token()};

    std::string refusal(const std::string& text) {
        try {
            const Token read{files.write("other", text)};
        } catch (const keys::KeyError& error) {
            return error.what();
        }
        return {};
    }
};

TEST_F(TokenOfAFile, IsShownByProgramsAndByBrowsers) {
    EXPECT_TRUE(token.is_shown_in("Bearer an0ther-word_of.24~chars"));
    EXPECT_TRUE(token.is_shown_in("bEARER  an0ther-word_of.24~chars"));
    EXPECT_TRUE(token.is_shown_in(token.authorization()));
    EXPECT_TRUE(token.is_shown_in("Basic YW5uYTphbjB0aGVyLXdvcmRfb2YuMjR+Y2hhcnM="));  // anna
    EXPECT_TRUE(token.is_shown_in("Basic OmFuMHRoZXItd29yZF9vZi4yNH5jaGFycw=="));      // nobody
}

TEST_F(TokenOfAFile, IsShownByNothingElse) {
    for (const std::string wrong :
         {"", " ", "Bearer", "Bearer ", "Bearer an0ther-word_of.24~char",
          "Bearer an0ther-word_of.24~charsx", "Bearer An0ther-word_of.24~chars",
          "an0ther-word_of.24~chars", "Token an0ther-word_of.24~chars",
          "Bearerx an0ther-word_of.24~chars", "Basic", "Basic ", "Basic =", "Basic ====",
          "Basic OmFuMHRoZXItd29yZF9vZi4yNH5jaGFycw=",       // cut
          "Basic OmFuMHRoZXItd29yZF9vZi4yNH5jaGFycw==AAAA",  // goes on behind its end
          "Basic YW4wdGhlci13b3JkX29mLjI0fmNoYXJz",          // no name, no colon
          "Basic !!!!!!!!", "Basic an0ther-word_of.24~chars"}) {
        EXPECT_FALSE(token.is_shown_in(wrong)) << wrong;
    }
    EXPECT_FALSE(token.is_shown_in("Basic " + std::string(100'000, 'A')));
}

TEST_F(TokenOfAFile, IsItsFirstLineAndNoGuess) {
    EXPECT_EQ(refusal("0123456789abcdef\r\nmore\n"), "");
    EXPECT_THAT(refusal("0123456789abcde\n"), HasSubstr("is no token: 16 to 256 letters"));
    EXPECT_THAT(refusal(""), HasSubstr("is no token"));
    EXPECT_THAT(refusal("a word with spaces in it\n"), HasSubstr("is no token"));
    EXPECT_THAT(refusal(std::string(257, 'a')), HasSubstr("openssl rand -hex 16"));
}

TEST_F(TokenOfAFile, IsRefusedWhenOthersMayReadIt) {
    ASSERT_EQ(::chmod(files.token().c_str(), 0644), 0);
    EXPECT_THROW(Token{files.token()}, keys::KeyError);
}

}  // namespace
}  // namespace romano::https::token_test
