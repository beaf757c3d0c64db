#include "overlay/daemon/condition_file.h"

#include <gmock/gmock.h>

#include <fstream>

#include "broker/daemon/refusal.h"
#include "tests/broker/daemon/captured_trace.h"
#include "tests/temporary_folder.h"

namespace romano::daemon::condition_file_test {
namespace {

using testing::HasSubstr;
using testing::Optional;

class ConditionFileTest : public testing::Test {
protected:
    void write(const std::string& text) const { std::ofstream{path} << text; }

    const tests::TemporaryFolder folder;
    const std::string path = (folder / "battery").string();
};

TEST_F(ConditionFileTest, IsReadAnewEachTime) {
    write("87\n");  // as /sys writes it
    ConditionFile file(path);
    EXPECT_THAT(file.look(), Optional(87U));
    write("0");
    EXPECT_THAT(file.look(), Optional(0U));
    write(" 100 ");
    EXPECT_THAT(file.look(), Optional(100U));
}

TEST_F(ConditionFileTest, WithoutANumberFrom0To100TheBrokerDoesNotStart) {
    for (const char* text : {"", "full", "101", "-1", "50 %", "3.5"}) {
        write(text);
        EXPECT_THROW(ConditionFile{path}, Refusal) << text;
    }
    EXPECT_THROW(ConditionFile{path + "-missing"}, Refusal);
}

TEST_F(ConditionFileTest, WhatIsNoNumberLaterIsSaidOnce) {
    write("87");
    ConditionFile file(path);
    write("?");
    const CapturedTrace trace;
    for (int i = 0; i < 3; ++i) EXPECT_FALSE(file.look());
    const std::string said = trace.text();
    EXPECT_THAT(said, HasSubstr(path + " holds no whole number"));
    EXPECT_EQ(said.find(path), said.rfind(path));
    write("12");
    EXPECT_THAT(file.look(), Optional(12U));
}

}  // namespace
}  // namespace romano::daemon::condition_file_test
