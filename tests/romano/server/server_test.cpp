// The ROMANO server on a scripted broker: who is acknowledged, listed, heeded and held.
#include "romano/server/server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <utility>

#include "romano/message/codec.h"

namespace romano::server::server_test {
namespace {

using namespace std::chrono_literals;
using message::RomanoId;
using testing::ElementsAre;
using testing::IsEmpty;

RomanoId id(std::string_view text) {
    return *RomanoId::parse(text);
}

std::string encoded(const message::Message& message) {
    std::array<std::uint8_t, message::max_message> octets{};
    const std::size_t size = message::encode(message, octets);
    return std::string{as_text(Bytes{octets}.first(size))};
}

/// What brokers share: the retained entries.
using Store = std::map<std::string, std::string, std::less<>>;

class ScriptedHost final : public Host {
public:
    explicit ScriptedHost(Store& shared) : store(shared) {}

    std::optional<Standing> standing(std::string_view client) const override {
        const auto found = sessions.find(client);
        return found == sessions.end() ? std::nullopt : std::optional{found->second};
    }
    std::vector<NodeEntry> entries() const override {
        std::vector<NodeEntry> out;
        for (const auto& [topic, text] : store) out.push_back(*parse_entry(topic, text));
        return out;
    }
    bool tidies_up_after(std::string_view home) const override { return lost.contains(home); }
    void publish(std::string_view topic, Bytes data, bool retain) override {
        if (!retain) {
            published.emplace_back(topic, as_text(data));
        } else if (data.empty()) {
            store.erase(std::string{topic});
        } else {
            store[std::string{topic}] = as_text(data);
            ++told;
        }
    }
    void hold(std::string_view client, bool is_held) override {
        is_held ? void(held.emplace(client)) : void(held.erase(std::string{client}));
    }

    Store& store;
    std::map<std::string, Standing, std::less<>> sessions;
    std::set<std::string, std::less<>> lost;
    std::set<std::string, std::less<>> held;
    std::vector<std::pair<std::string, std::string>> published;
    int told = 0;
};

/// One broker with its server; several share a store, as brokers do.
class Broker {
public:
    Broker(Store& store, std::string name) : host(store), core({.name = std::move(name)}) {}

    void hears(std::string_view client, std::string_view topic, const message::Message& message) {
        hears_text(client, topic, encoded(message));
    }
    void hears_text(std::string_view client, std::string_view topic, std::string_view data) {
        core.on_publish(now, client, topic, as_octets(data), host);
    }
    void connects(const std::string& node, bool kept = false) {
        host.sessions[node] = {.connected = true, .kept = kept};
        hears(node, init_topic, message::ConnectionRequest{id(node)});
    }
    void beats(std::string_view node) { hears(node, common_topic, message::Heartbeat{id(node)}); }
    void waits(Duration time) {
        for (const Instant end = now + time; now < end; now += 100ms) core.on_tick(now, host);
    }
    [[nodiscard]] std::optional<NodeEntry> entry(const std::string& node) const {
        const auto found = host.store.find("$ROMANO/nodes/" + node);
        if (found == host.store.end()) return std::nullopt;
        return parse_entry(found->first, found->second);
    }

    ScriptedHost host;
    ServerCore core;
    Instant now{1h};
};

class RomanoServer : public testing::Test {
protected:
    Store store;
    Broker b1{store, "b1"};
    Broker b2{store, "b2"};
};

TEST_F(RomanoServer, AcknowledgesAConnectionRequestOnTheNodesOwnTopic) {
    b1.connects("abcd1234");
    EXPECT_THAT(b1.host.published,
                ElementsAre(std::pair{"abcd1234", encoded(message::ConnectionAck{})}));
    ASSERT_TRUE(b2.entry("abcd1234"));
    EXPECT_EQ(b2.entry("abcd1234")->home, "b1");
    EXPECT_EQ(b2.entry("abcd1234")->state, NodeState::connected);
}

TEST_F(RomanoServer, AcknowledgesEveryRepetitionAndTellsOfTheNodeOnce) {
    for (int i = 0; i < 3; ++i) b1.connects("abcd1234");
    EXPECT_EQ(b1.host.published.size(), 3U);
    EXPECT_EQ(b1.host.told, 1);
}

TEST_F(RomanoServer, AcknowledgesTheAuthorsFirmwareInItsOwnForm) {
    b1.host.sessions["0433ed81"] = {.connected = true};
    b1.hears_text("0433ed81", legacy_init_topic, "00433ed81");
    EXPECT_THAT(b1.host.published, ElementsAre(std::pair{"0433ed81", "ACK"}));
    EXPECT_EQ(b1.entry("0433ed81")->form, Form::legacy);
}

TEST_F(RomanoServer, AnswersEachFormOnItsTopicOnly) {
    b1.hears_text("0433ed81", init_topic, "00433ed81");
    b1.hears("0433ed81", legacy_init_topic, message::ConnectionRequest{id("0433ed81")});
    EXPECT_THAT(b1.host.published, IsEmpty());
    EXPECT_EQ(b1.core.counters().malformed, 2U);
}

TEST_F(RomanoServer, ListsTheConnectedNodesOfTheWholeClusterToTheAsker) {
    b1.connects("00000001");
    b2.connects("00000002");
    b2.hears("abcd1234", init_topic, message::RequestConnectedNodes{id("abcd1234")});
    ASSERT_FALSE(b2.host.published.empty());
    EXPECT_EQ(b2.host.published.back(),
              (std::pair<std::string, std::string>{
                  "abcd1234", encoded(message::ConnectedNodes{as_octets("0000000100000002")})}));
}

TEST_F(RomanoServer, AListOfManyComesInMessagesOf31AndEndsWithAShorterOne) {
    for (int i = 0; i < 62; ++i) {
        std::string node = "000000" + std::to_string(10 + i);
        b1.connects(node);
    }
    b1.host.published.clear();
    b1.hears("abcd1234", init_topic, message::RequestConnectedNodes{id("abcd1234")});
    std::vector<std::size_t> counts;
    for (const auto& [topic, data] : b1.host.published) {
        const auto message = message::decode(as_octets(data));
        ASSERT_TRUE(message.has_value());
        counts.push_back(std::get<message::ConnectedNodes>(*message).count());
    }
    EXPECT_THAT(counts, ElementsAre(31U, 31U, 0U));
}

TEST_F(RomanoServer, TheAuthorsFirmwareGetsACountAndAMessageForEachNode) {
    b1.connects("00000001");
    b1.host.published.clear();
    b1.hears_text("0433ed81", legacy_init_topic, "1");
    EXPECT_THAT(b1.host.published,
                ElementsAre(std::pair{"0433ed81", "31"}, std::pair{"0433ed81", "400000001"}));
}

TEST_F(RomanoServer, ATurnOfTheRssiGameIsNobodysRequest) {
    b1.hears_text("0433ed81", legacy_init_topic, "20433ed81");
    EXPECT_THAT(b1.host.published, IsEmpty());
    EXPECT_EQ(b1.core.counters().malformed, 0U);
}

TEST_F(RomanoServer, AnHeirTakesTheEntryOfAnAdoptedNode) {
    b1.connects("abcd1234");
    b2.host.sessions["abcd1234"] = {.connected = true};  // adopted
    b2.waits(1100ms);
    EXPECT_EQ(b2.entry("abcd1234")->home, "b2");
    EXPECT_THAT(b2.host.published, IsEmpty()) << "the node was acknowledged before";
}

TEST_F(RomanoServer, ANodeThatLeftIsForgotten) {
    b1.connects("abcd1234");
    b1.host.sessions["abcd1234"] = {.connected = false, .kept = false};
    b1.waits(1100ms);
    EXPECT_FALSE(b1.entry("abcd1234"));
}

TEST_F(RomanoServer, ANodeOfAKeptSessionIsAwayAndNotListed) {
    b1.connects("abcd1234", true);
    b1.host.sessions["abcd1234"].connected = false;
    b1.waits(1100ms);
    EXPECT_EQ(b1.entry("abcd1234")->state, NodeState::away);
    b1.host.published.clear();
    b1.hears("00000001", init_topic, message::RequestConnectedNodes{id("00000001")});
    EXPECT_EQ(b1.host.published[0].second, encoded(message::ConnectedNodes{}));
}

TEST_F(RomanoServer, AnEntryThatTheOtherSideDeletedComesBack) {
    b1.connects("abcd1234");
    store.clear();
    b1.waits(1100ms);
    EXPECT_TRUE(b1.entry("abcd1234"));
}

TEST_F(RomanoServer, EntriesOfALostBrokerThatNobodyClaimsAreDeletedByOne) {
    b1.connects("abcd1234");
    b2.waits(60s);
    EXPECT_TRUE(b2.entry("abcd1234")) << "b1 may live";
    b2.host.lost.insert("b1");
    b2.waits(20s);
    EXPECT_TRUE(b2.entry("abcd1234")) << "an heir may come";
    b2.waits(15s);
    EXPECT_FALSE(b2.entry("abcd1234"));
}

TEST_F(RomanoServer, MessagesWaitForANodeWhoseHeartbeatsAreMissingUntilTheyAreBack) {
    b1.connects("abcd1234");
    for (int i = 0; i < 5; ++i) {
        b1.beats("abcd1234");
        b1.waits(1s);
    }
    EXPECT_THAT(b1.host.held, IsEmpty());
    b1.waits(4s);
    EXPECT_THAT(b1.host.held, ElementsAre("abcd1234"));
    EXPECT_EQ(b1.entry("abcd1234")->state, NodeState::silent);
    b1.beats("abcd1234");
    EXPECT_THAT(b1.host.held, IsEmpty());
    EXPECT_EQ(b1.entry("abcd1234")->state, NodeState::connected);
}

TEST_F(RomanoServer, AnHeirGoesOnHoldingForASilentNode) {
    b1.connects("abcd1234");
    b1.beats("abcd1234");
    b1.waits(12s);
    ASSERT_EQ(b1.entry("abcd1234")->state, NodeState::silent);
    b2.host.sessions["abcd1234"] = {.connected = true};
    b2.waits(1100ms);
    EXPECT_THAT(b2.host.held, ElementsAre("abcd1234"));
    b2.connects("abcd1234");
    EXPECT_THAT(b2.host.held, IsEmpty());
}

TEST_F(RomanoServer, ANodeWithoutHeartbeatsIsNeverSilent) {
    b1.connects("abcd1234");
    b1.waits(1h);
    EXPECT_EQ(b1.entry("abcd1234")->state, NodeState::connected);
    EXPECT_EQ(b1.host.told, 1) << "nothing to tell, nothing told";
}

TEST_F(RomanoServer, HeartbeatsAreToldAtMostEveryTenSeconds) {
    b1.connects("abcd1234");
    for (int i = 0; i < 60; ++i) {
        b1.beats("abcd1234");
        b1.waits(1s);
    }
    EXPECT_LE(b1.host.told, 9);
    EXPECT_GE(b1.host.told, 6);
}

TEST_F(RomanoServer, OnlyTheNodeItselfBeatsForIt) {
    b1.connects("abcd1234");
    b1.hears("stranger", common_topic, message::Heartbeat{id("abcd1234")});
    EXPECT_EQ(b1.entry("abcd1234")->heartbeat_unix_ms, 0U);
}

TEST_F(RomanoServer, BeyondItsBoundItAcknowledgesNoFurtherNode) {
    ServerCore core{{.name = "b1", .most_nodes = 1}};
    const auto ask = [&](const char* node) {
        b1.host.sessions[node] = {.connected = true};
        const std::string request = encoded(message::ConnectionRequest{id(node)});
        core.on_publish(b1.now, node, init_topic, as_octets(request), b1.host);
    };
    ask("00000001");
    ask("00000002");
    ask("00000001");
    EXPECT_EQ(core.counters().acknowledged, 2U);
    EXPECT_EQ(core.counters().refused, 1U);
}

TEST_F(RomanoServer, GarbageIsCountedAndDropped) {
    for (const std::string_view garbage : {"", "x",
                                           "\x0B\x09"
                                           "abcd123",
                                           "\x0B\x0A"
                                           "ABCD1234"}) {
        for (const auto topic : observed_topics) b1.hears_text("c", topic, garbage);
    }
    EXPECT_THAT(b1.host.published, IsEmpty());
    EXPECT_TRUE(store.empty());
    EXPECT_EQ(b1.core.counters().malformed, 8U);
}

TEST(NeverRetained, IsWhatMovesARobotInWhateverForm) {
    const std::string movement =
        encoded(message::MovementControl{message::MovementType::front, as_octets("\1\1\1\1")});
    const std::string key = encoded(message::RemoteControl{as_octets("w")});
    for (const std::string_view topic : {"abcd1234", "common", "team/red"}) {
        EXPECT_TRUE(is_never_retained(topic, as_octets(movement))) << topic;
        EXPECT_TRUE(is_never_retained(topic, as_octets(key))) << topic;
    }
    for (const std::string_view topic : {"0433ed81", "common"}) {
        for (const std::string_view text :
             {"70401f400001e", "70401F400001E", "8w", "8a", "8s", "8d"}) {
            EXPECT_TRUE(is_never_retained(topic, as_octets(text))) << topic << ' ' << text;
        }
    }
}

TEST(NeverRetained, IsNobodysInnocentText) {
    for (const std::string_view text : {"70401f400001e", "8s"}) {
        for (const std::string_view topic : {"uptime", "0433ed8", "0433ED81", "a/common"}) {
            EXPECT_FALSE(is_never_retained(topic, as_octets(text))) << topic << ' ' << text;
        }
    }
    for (const std::string_view text : {"", "8", "8x", "80", "7", "70401f400001", "70401f40000zz",
                                        "0hello", "1line", "6 0.10 0.10 7", "ACK"}) {
        EXPECT_FALSE(is_never_retained("0433ed81", as_octets(text))) << text;
    }
    EXPECT_FALSE(
        is_never_retained("0433ed81", as_octets(encoded(message::NormalData{as_octets("8w")}))));
}

}  // namespace
}  // namespace romano::server::server_test
