#include "romano/client/topic_table.h"

#include <gtest/gtest.h>

namespace romano::client::topic_table_test {
namespace {

using mqttsn::TopicId;
using Use = TopicTable::Use;

class TopicTableTest : public testing::Test {
protected:
    TopicTable::Entry entries_[3];
    char names_[10];
    TopicTable table{entries_, names_};

    /// A name that messages come under.
    bool put(TopicId id, std::string_view name) { return table.put(id, name, Use::to_receive); }
};

TEST_F(TopicTableTest, FindsByNameAndById) {
    EXPECT_TRUE(put(TopicId{1}, "a/b"));
    EXPECT_TRUE(put(TopicId{2}, "c"));
    EXPECT_EQ(table.id_of("a/b"), TopicId{1});
    EXPECT_EQ(table.id_of("c"), TopicId{2});
    EXPECT_EQ(table.id_of("a"), mqttsn::no_topic_id);
    EXPECT_EQ(table.name_of(TopicId{2}), "c");
    EXPECT_EQ(table.name_of(TopicId{3}), "");
}

TEST_F(TopicTableTest, GivesAKnownIdANewName) {
    EXPECT_TRUE(put(TopicId{1}, "abc"));
    EXPECT_TRUE(put(TopicId{2}, "d"));
    EXPECT_TRUE(put(TopicId{1}, "012345678"));
    EXPECT_EQ(table.name_of(TopicId{1}), "012345678");
    EXPECT_EQ(table.name_of(TopicId{2}), "d");
    EXPECT_EQ(table.id_of("abc"), mqttsn::no_topic_id);
}

TEST_F(TopicTableTest, RefusesNewNamesWhenFull) {  // P8
    EXPECT_TRUE(put(TopicId{1}, "abc"));
    EXPECT_TRUE(put(TopicId{2}, "def"));
    EXPECT_FALSE(put(TopicId{3}, "12345"));
    EXPECT_EQ(table.name_of(TopicId{1}), "abc");
    EXPECT_TRUE(put(TopicId{3}, "1234"));
    EXPECT_FALSE(table.make_room_for("x"));
    EXPECT_FALSE(put(TopicId{4}, "x"));
    EXPECT_TRUE(put(TopicId{3}, "1234"));
}

TEST_F(TopicTableTest, DoesNotKeepTheOldNameOfAnIdWhoseNewOneDoesNotFit) {
    EXPECT_TRUE(put(TopicId{1}, "abc"));
    EXPECT_TRUE(put(TopicId{2}, "def"));
    EXPECT_FALSE(put(TopicId{1}, "12345678"));
    EXPECT_EQ(table.name_of(TopicId{1}), "");
    EXPECT_EQ(table.name_of(TopicId{2}), "def");
}

TEST_F(TopicTableTest, KeepsSeveralIdsOfANameWhileThereIsRoom) {  // G15
    EXPECT_TRUE(put(TopicId{1}, "abc"));
    EXPECT_TRUE(put(TopicId{2}, "abc"));
    EXPECT_TRUE(put(TopicId{3}, "abc"));
    EXPECT_EQ(table.name_of(TopicId{1}), "abc");
    EXPECT_TRUE(put(TopicId{4}, "abc"));
    EXPECT_EQ(table.name_of(TopicId{1}), "");
    EXPECT_EQ(table.name_of(TopicId{2}), "abc");
    EXPECT_EQ(table.name_of(TopicId{4}), "abc");
}

TEST_F(TopicTableTest, ForgetsFromTheMiddle) {
    EXPECT_TRUE(put(TopicId{1}, "abc"));
    EXPECT_TRUE(put(TopicId{2}, "de"));
    EXPECT_TRUE(put(TopicId{3}, "f"));
    table.forget(TopicId{2});
    table.forget(TopicId{9});
    EXPECT_EQ(table.name_of(TopicId{1}), "abc");
    EXPECT_EQ(table.name_of(TopicId{2}), "");
    EXPECT_EQ(table.name_of(TopicId{3}), "f");
    EXPECT_TRUE(put(TopicId{4}, "012345"));
    EXPECT_EQ(table.name_of(TopicId{4}), "012345");
}

TEST_F(TopicTableTest, TheOldestNameToPublishOnGivesWay) {
    EXPECT_TRUE(table.put(TopicId{1}, "ab", Use::to_publish));
    EXPECT_TRUE(put(TopicId{2}, "cd"));
    EXPECT_TRUE(table.put(TopicId{3}, "ef", Use::to_publish));
    EXPECT_TRUE(table.put(TopicId{4}, "gh", Use::to_publish));
    EXPECT_EQ(table.id_of("ab"), mqttsn::no_topic_id);
    EXPECT_EQ(table.id_of("cd"), TopicId{2});
    EXPECT_EQ(table.id_of("ef"), TopicId{3});
    EXPECT_TRUE(put(TopicId{5}, "12345678")) << "two of them give way, for their octets";
    EXPECT_EQ(table.id_of("ef"), mqttsn::no_topic_id);
    EXPECT_EQ(table.id_of("gh"), mqttsn::no_topic_id);
    EXPECT_EQ(table.id_of("cd"), TopicId{2});
    EXPECT_FALSE(table.put(TopicId{6}, "x", Use::to_publish)) << "what is received stays";
}

TEST(TopicTable, ANameThatIsPublishedOnAndThenSubscribedToStays) {
    TopicTable::Entry entries[2];
    char names[16];
    TopicTable table{entries, names};
    EXPECT_TRUE(table.put(TopicId{1}, "ab", Use::to_publish));
    EXPECT_TRUE(table.put(TopicId{1}, "ab", Use::to_receive));
    EXPECT_TRUE(table.put(TopicId{2}, "cd", Use::to_publish));
    EXPECT_TRUE(table.put(TopicId{3}, "ef", Use::to_publish));
    EXPECT_EQ(table.id_of("ab"), TopicId{1});
    EXPECT_EQ(table.id_of("cd"), mqttsn::no_topic_id);
}

}  // namespace
}  // namespace romano::client::topic_table_test
