// Clients that have one address: behind a NAT that keeps source ports, or one after the other under
// two ids at one port. Who was heard last at a client address and service address is who speaks
// there (G7), and nobody is ever read with another client's topic ids.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/broker/core/adopting_brokers.h"

namespace romano::broker::shared_address_test {
namespace {

constexpr std::uint16_t port = 7000;

class SharedAddress : public ::testing::Test {
protected:
    SharedAddress() { b.via = second; }

    /// Each registers and hears topics of its own, under the same ids.
    void begins(ScriptedClient& client, bool clean = true, std::uint16_t keep_alive_s = 0) {
        client.connects(clean, keep_alive_s);
        client.subscribes("to/" + client.id, Qos::at_least_once);
        EXPECT_EQ(client.registers("from/" + client.id), TopicId{2});
    }
    void watches() {
        watcher.connects();
        watcher.subscribes("#", Qos::at_most_once);
    }
    /// What it publishes under its id is its own topic, and it hears what is for it.
    void lives(ScriptedBroker& at, ScriptedClient& client) {
        client.publishes(TopicId{2}, "from " + client.id, Qos::at_least_once);
        EXPECT_TRUE(at.core.image(client.id));
        at.core.publish(at.now, "to/" + client.id, as_octets("to " + client.id), Qos::at_least_once,
                        false, at.actions);
        at.drain();
        client.hears_publish("to " + client.id, Qos::at_least_once);
        client.hears_nothing();
    }
    void adopts(std::string_view client, const SessionImage& image) {
        EXPECT_TRUE(heir.core.adopt(heir.now, image, {}, heir.actions)) << client;
        heir.drain();
    }

    const Endpoint second = loopback(9, 1883);
    const Endpoint third = loopback(10, 1883);
    ScriptedBroker home{options_of("home")};
    ScriptedBroker heir{options_of("heir")};
    ScriptedClient watcher{home, "watcher"};
    ScriptedClient a{home, "a", port};
    ScriptedClient b{home, "b", port};
};

TEST_F(SharedAddress, TwoClientsAreToldApartByTheServiceAddressThatTheyTalkTo) {
    begins(a);
    begins(b);
    lives(home, a);
    lives(home, b);
    home.expects_mirror_to_agree();
}

TEST_F(SharedAddress, TheirWillPromptsAreTheirOwn) {
    a.says(a.connect(true, 0, true));
    b.says(b.connect(true, 0, true));
    a.hears<Willtopicreq>();
    b.hears<Willtopicreq>();
    a.says(Willtopic{});
    EXPECT_EQ(a.hears<Connack>().return_code, ReturnCode::accepted);
    b.says(Willtopic{});
    EXPECT_EQ(b.hears<Connack>().return_code, ReturnCode::accepted);
    EXPECT_THAT(home.core.client_ids(), testing::UnorderedElementsAre("a", "b"));
}

// At a peer there may be another client's session that was heard at that address.
TEST_F(SharedAddress, WhoAnswersAWillPromptIsKnownHere) {
    const Octets topic = ScriptedClient::encoded(Willtopic{Qos::at_most_once, false, "gone"});
    EXPECT_FALSE(home.core.serves(a.via, a.address.endpoint, topic));
    a.says(a.connect(true, 0, true));
    EXPECT_TRUE(home.core.serves(a.via, a.address.endpoint, topic));
    EXPECT_FALSE(home.core.serves(second, a.address.endpoint, topic));
}

TEST_F(SharedAddress, ClientsWithoutAnIdAreTwoAsWell) {  // G20
    a.id = b.id = "";
    a.connects();
    b.connects();
    EXPECT_EQ(home.core.session_count(), 2U);
}

TEST_F(SharedAddress, ForwardersClientsAreToldApartByTheirNodeIdsFirst) {  // 5.5
    b.via = a.via;
    a.address.wireless_node_id = "1";
    b.address.wireless_node_id = "2";
    begins(a);
    begins(b);
    b.via = second;  // it roams, and nobody else has its node id
    b.publishes(TopicId{2}, "from b", Qos::at_least_once);
    lives(home, a);
    lives(home, b);
}

TEST_F(SharedAddress, OneThatIsAloneAtItsAddressMayGoToAnotherServiceAddress) {
    begins(a);
    a.via = third;
    lives(home, a);
    EXPECT_EQ(home.core.header("a")->via, third);
    home.expects_mirror_to_agree();
}

TEST_F(SharedAddress, WhereNeitherWasHeardNobodyKnowsWhoSpeaks) {
    begins(a);
    begins(b);
    watches();
    b.via = third;
    b.says(Publish{false, Qos::at_most_once, false, TopicIdType::normal, TopicId{2}, no_msg_id,
                   as_octets("whose?")});
    b.hears<Disconnect>();
    watcher.hears_nothing();
    b.connects(false);  // it says who it is
    b.publishes(TopicId{2}, "from b", Qos::at_least_once);
    EXPECT_EQ(watcher.hears<Register>().topic_name, "from/b");
    lives(home, a);
}

TEST_F(SharedAddress, APeersClientMayBeTheOneThatSpeaks) {
    struct Peers final : Audience {
        [[nodiscard]] bool wants(std::string_view) const override { return false; }
        [[nodiscard]] std::size_t longest_queue(std::string_view, Instant) const override {
            return 0;
        }
        [[nodiscard]] bool share_address_with(const SessionHeader& own) const override {
            return own.client_id == "a";
        }
    } peers;
    home.core.set_audience(peers);
    begins(a);
    const Octets publish = ScriptedClient::encoded(
        Publish{false, Qos::at_most_once, false, TopicIdType::normal, TopicId{2}, no_msg_id, {}});
    EXPECT_TRUE(home.core.serves(a.via, a.address.endpoint, publish));
    EXPECT_FALSE(home.core.serves(third, a.address.endpoint, publish));
    a.via = third;
    a.says_octets(publish);
    a.hears<Disconnect>();
}

TEST_F(SharedAddress, WhereOneWasLeftBehindNobodyElseSpeaks) {
    begins(a);
    begins(b, true, 10);
    home.waits(16s);
    b.ignores_what_came();  // it was asked for a sign of life
    ASSERT_EQ(home.core.header("b")->state, SessionState::lost);
    watches();
    b.says(Publish{false, Qos::at_most_once, false, TopicIdType::normal, TopicId{2}, no_msg_id,
                   as_octets("from b")});
    b.hears<Disconnect>();
    watcher.hears_nothing();
    lives(home, a);
}

// 6.8: without a connection one may talk to any gateway.
TEST_F(SharedAddress, APublishWithoutConnectionMovesNobody) {
    begins(a);
    ScriptedClient elsewhere{home, "a", port};
    elsewhere.via = third;
    elsewhere.says(Publish{false, Qos::without_connection, false, TopicIdType::predefined,
                           TopicId{7}, no_msg_id, as_octets("hello")});
    elsewhere.hears_nothing();
    EXPECT_EQ(home.core.header("a")->via, a.via);
    lives(home, a);
}

TEST_F(SharedAddress, AnHeirOfBothServesBoth) {
    begins(a);
    begins(b);
    for (ScriptedClient* client : {&a, &b}) {
        adopts(client->id, image_of(home, client->id));
        client->moves_to(heir);
    }
    lives(heir, a);
    lives(heir, b);
    heir.expects_mirror_to_agree();
}

// One device that was started again under another id, without DISCONNECT.
TEST_F(SharedAddress, AnHeirKnowsWhoWasHeardLastInWhateverOrderTheyCome) {
    b.via = a.via;
    begins(a, true, 10);
    a.says(Willtopicupd{Qos::at_most_once, false, "gone"});
    a.hears<Willtopicresp>();
    a.says(Willmsgupd{as_octets("a")});
    a.hears<Willmsgresp>();
    begins(b);
    const SessionImage images[] = {image_of(home, "a"), image_of(home, "b")};
    for (const bool is_later_first : {false, true}) {
        ScriptedBroker next{options_of("heir")};
        for (int i : {0, 1}) {
            EXPECT_TRUE(
                next.core.adopt(next.now, images[is_later_first ? 1 - i : i], {}, next.actions));
            next.drain();
        }
        ScriptedClient still_there{next, "b", port};
        ScriptedClient reader{next, "reader"};
        reader.connects();
        reader.subscribes("gone", Qos::at_most_once);
        lives(next, still_there);
        next.waits(20s);  // longer than a's keep-alive
        still_there.hears_nothing();
        EXPECT_EQ(next.core.header("a")->state, SessionState::lost);
        EXPECT_EQ(next.core.header("b")->state, SessionState::active);
        reader.hears_publish("a");
        reader.hears_nothing();  // once
    }
}

// It outlives what its former home says, as after a heal.
TEST_F(SharedAddress, AnOwnClientThatWasHeardLaterKeepsItsPlace) {
    begins(a);
    const SessionImage old = image_of(home, "a");
    heir.waits(1h);
    ScriptedClient later{heir, "b", port};
    begins(later);
    adopts("a", old);
    lives(heir, later);
}

TEST_F(SharedAddress, ASleeperThatSaysWhoItIsHasItsPlaceBack) {  // 6.14e
    begins(a, false, 10);
    a.says(Disconnect{true, 60});
    a.hears<Disconnect>();
    b.via = a.via;
    begins(b);
    a.says(Pingreq{"a"});
    a.hears<Pingresp>();
    EXPECT_EQ(home.core.header("a")->state, SessionState::asleep);
    // What comes from there now is the sleeper's: its own topic ids hold.
    a.publishes(TopicId{2}, "from a", Qos::at_least_once);
    home.expects_mirror_to_agree();
}

}  // namespace
}  // namespace romano::broker::shared_address_test
