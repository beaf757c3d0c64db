#include "romano/server/node_entry.h"

#include <gtest/gtest.h>

namespace romano::server::node_entry_test {
namespace {

NodeEntry entry() {
    return {.id = *message::RomanoId::parse("abcd1234"),
            .form = Form::legacy,
            .state = NodeState::silent,
            .heartbeat_unix_ms = 1'790'000'000'123,
            .home = "r1",
            .client = "a client=x"};
}

TEST(NodeEntry, IsOneLineThatPeopleCanRead) {
    EXPECT_EQ(entry_topic(entry().id), "$ROMANO/nodes/abcd1234");
    EXPECT_EQ(to_text(entry()),
              "form=legacy state=silent heartbeat_unix_ms=1790000000123 home=r1 client=a client=x");
}

TEST(NodeEntry, GoesBothWays) {
    EXPECT_EQ(parse_entry(entry_topic(entry().id), to_text(entry())), entry());
}

TEST(NodeEntry, EveryTruncationUpToTheClientIsRefused) {
    const std::string text = to_text(entry());
    for (std::size_t size = 0; size < text.find("client="); ++size) {
        EXPECT_FALSE(parse_entry("$ROMANO/nodes/abcd1234", text.substr(0, size))) << size;
    }
}

TEST(NodeEntry, OtherTopicsAndUnknownWordsAreRefused) {
    const std::string text = to_text(entry());
    EXPECT_FALSE(parse_entry("$ROMANO/nodes/ABCD1234", text));
    EXPECT_FALSE(parse_entry("$ROMANO/nodes/abcd12345", text));
    EXPECT_FALSE(parse_entry("nodes/abcd1234", text));
    EXPECT_FALSE(parse_entry("$ROMANO/nodes/abcd1234",
                             "form=odd state=silent heartbeat_unix_ms=1 home=r1 client=x"));
    EXPECT_FALSE(parse_entry("$ROMANO/nodes/abcd1234",
                             "form=legacy state=silent heartbeat_unix_ms=x home=r1 client=x"));
}

}  // namespace
}  // namespace romano::server::node_entry_test
