// What a broker knows of its clients' packets is there again after its end, however it came.

#include "broker/daemon/heard_file.h"

#include <gtest/gtest.h>

#include <fstream>

#include "romano/keys/key_error.h"
#include "tests/temporary_folder.h"

namespace romano::daemon::heard_file_test {
namespace {

using broker::PacketsHeard;
using protection::Heard;
using protection::RunId;

constexpr protection::SenderId a{0xA};
constexpr protection::SenderId b{0xFF, 0xB};

struct HeardFiles : testing::Test {
    tests::TemporaryFolder folder;
    std::filesystem::path path = folder / "clients.heard";
};

TEST_F(HeardFiles, TheLastWordOnAClientCounts) {
    {
        HeardFile file(path);
        EXPECT_FALSE(file.of(a));
        EXPECT_TRUE(file.add({a, {RunId{0}, 4096}}));
        EXPECT_TRUE(file.add({b, {RunId{4'000'000'000}, 4'000'004'096}}));
        EXPECT_TRUE(file.add({a, {RunId{0}, 8192}}));
    }
    const HeardFile again(path);
    EXPECT_EQ(again.of(a), (Heard{RunId{0}, 8192}));
    EXPECT_EQ(again.of(b), (Heard{RunId{4'000'000'000}, 4'000'004'096}));
}

TEST_F(HeardFiles, ALineThatWasCutSaysNothing) {
    {
        HeardFile file(path);
        EXPECT_TRUE(file.add({a, {RunId{0}, 4096}}));
    }
    std::ofstream(path, std::ios::app) << "0a00000000000000 0 81";
    EXPECT_EQ(HeardFile(path).of(a), (Heard{RunId{0}, 4096}));
}

TEST_F(HeardFiles, StaysSmall) {
    HeardFile file(path);
    for (std::uint32_t i = 1; i < 10'000; ++i) {
        ASSERT_TRUE(file.add({a, {RunId{0}, i * protection::numbers_a_block}}));
    }
    EXPECT_LT(std::filesystem::file_size(path), 50'000U);
    EXPECT_EQ(file.of(a), (Heard{RunId{0}, 9'999 * protection::numbers_a_block}));
}

TEST_F(HeardFiles, GrowsWhereItCannotBeWrittenAnewAndIsSmallOnceItCan) {
    HeardFile file(path);
    const std::filesystem::path in_the_way = path.string() + ".next";
    std::filesystem::create_directory(in_the_way);
    std::uint32_t last = 0;
    const auto add_many = [&] {
        for (int i = 0; i < 10'000; ++i) {
            last += protection::numbers_a_block;
            ASSERT_TRUE(file.add({a, {RunId{0}, last}}));
        }
    };
    add_many();
    EXPECT_GT(std::filesystem::file_size(path), 100'000U);
    std::filesystem::copy_file(path, folder / "copy");
    EXPECT_EQ(HeardFile(folder / "copy").of(a), (Heard{RunId{0}, last})) << "of a killed broker";
    std::filesystem::remove(in_the_way);
    add_many();
    EXPECT_LT(std::filesystem::file_size(path), 50'000U);
    EXPECT_EQ(HeardFile(path).of(a), (Heard{RunId{0}, last}));
}

TEST_F(HeardFiles, AnOrderlyEndKeepsExactNumbers) {
    {
        HeardFile file(path);
        EXPECT_TRUE(file.add({a, {RunId{0}, 4096}}));
        file.add_all({{a, {RunId{0}, 17}}});
    }
    EXPECT_EQ(HeardFile(path).of(a), (Heard{RunId{0}, 17}));
}

TEST_F(HeardFiles, IsNotReadWhenOthersMayWriteIt) {
    { const HeardFile file(path); }
    std::filesystem::permissions(path, std::filesystem::perms::others_write,
                                 std::filesystem::perm_options::add);
    EXPECT_THROW(HeardFile{path}, keys::KeyError);
}

}  // namespace
}  // namespace romano::daemon::heard_file_test
