// One PUBLISH to many that listen to the broker's cell: romano/mqttsn/cell.md.

#include "romano/mqttsn/cell.h"

#include <gtest/gtest.h>

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "romano/mqttsn/body.h"
#include "romano/mqttsn/frame.h"
#include "tests/broker/core/scripted_client.h"

namespace romano::broker::cell_test {
namespace {

const Endpoint group{.address = {239, 1, 2, 3}, .port = 1884, .family = Endpoint::Family::ipv4};

BrokerOptions with_a_cell() {
    BrokerOptions options = logging_options();
    options.cell_group = group;
    return options;
}

/// What one datagram to the cell says.
struct Cast {
    Qos qos;
    std::string topic;
    std::string payload;
    MsgId msg_id;
    unsigned answer_steps;
    std::vector<std::uint16_t> exceptions;
    MsgId behind;

    [[nodiscard]] bool is_for(const ScriptedClient& client) const {
        return std::ranges::count(exceptions, listener_number(client.id)) == 0;
    }
};

class OneCell : public ::testing::Test {
protected:
    OneCell() {
        publisher.connects();
        common = publisher.registers("common");
        for (int i = 0; i < 4; ++i) {
            robots.emplace_back(broker, "robot-" + std::to_string(i));
            robots.back().connects();
            robots.back().subscribes("common", Qos::at_least_once);
            robots.back().subscribes(cell_topic, Qos::at_most_once);
        }
    }

    void publishes(std::string_view data, Qos qos) { publisher.publishes(common, data, qos); }

    std::optional<Cast> hears_cast(ScriptedBroker& from) {
        auto& inbox = from.inboxes[Origin{from.via, ClientAddress{group, {}}}];
        if (inbox.empty()) return {};
        const Octets octets = inbox.front();
        inbox.pop_front();
        const auto frame = decode_frame(octets);
        if (!frame || frame->type != MsgType::publish) return {};
        const auto body = read_body(frame->type, frame->body);
        const auto cell = body ? read_cell_publish(*body) : std::nullopt;
        if (!cell) return {};
        Cast cast{qos_in(body->flags), std::string{cell->name}, std::string{as_text(cell->payload)},
                  body->msg_id,        cell->answer_steps,      {},
                  cell->behind};
        for (std::size_t at = 0; at < cell->exceptions.size(); at += 2) {
            cast.exceptions.push_back(be16(cell->exceptions, at));
        }
        return cast;
    }
    std::optional<Cast> hears_cast() { return hears_cast(broker); }

    static void answers(ScriptedClient& robot, const Cast& cast) {
        robot.says(Puback{TopicId{1}, cast.msg_id, ReturnCode::accepted});
    }

    ScriptedBroker broker{with_a_cell()};
    ScriptedClient publisher{broker, "publisher"};
    TopicId common{};
    std::deque<ScriptedClient> robots;
};

TEST_F(OneCell, AtQos0HearsOneDatagramAndNobodyAnother) {
    publishes("stop", Qos::at_most_once);
    const auto cast = hears_cast();
    ASSERT_TRUE(cast);
    EXPECT_EQ(cast->topic, "common");
    EXPECT_EQ(cast->payload, "stop");
    EXPECT_EQ(cast->qos, Qos::at_most_once);
    EXPECT_TRUE(cast->exceptions.empty());
    EXPECT_FALSE(hears_cast());
    for (ScriptedClient& robot : robots) robot.hears_nothing();
    EXPECT_EQ(broker.core.counters().cell_publishes, 1u);
    EXPECT_EQ(broker.core.counters().cell_deliveries, 4u);
}

TEST_F(OneCell, UnmodifiedClientsGoOnReceivingUnicasts) {
    ScriptedClient other{broker, "unmodified"};
    other.connects();
    other.subscribes("common", Qos::at_least_once);
    publishes("stop", Qos::at_most_once);
    other.hears_publish("stop");
    publishes("go", Qos::at_least_once);
    other.hears_publish("go", Qos::at_least_once);
    EXPECT_TRUE(hears_cast());
    EXPECT_TRUE(hears_cast());
    for (ScriptedClient& robot : robots) robot.hears_nothing();
}

TEST_F(OneCell, WithoutAGroupListenersGetUnicasts) {
    ScriptedBroker plain{logging_options()};
    ScriptedClient a{plain, "a"};
    ScriptedClient b{plain, "b"};
    for (ScriptedClient* each : {&a, &b}) {
        each->connects();
        each->subscribes("t", Qos::at_least_once);
        each->subscribes(cell_topic, Qos::at_most_once);  // no brokers refuse it
    }
    a.publishes(a.registers("t"), "x");
    a.hears_publish("x");
    b.hears_publish("x");
}

TEST_F(OneCell, AtQos1OneDatagramAsksAllForAnswersSpreadInTime) {
    publishes("go", Qos::at_least_once);
    const auto cast = hears_cast();
    ASSERT_TRUE(cast);
    EXPECT_EQ(cast->qos, Qos::at_least_once);
    EXPECT_EQ(cast->answer_steps, 2u);  // four times 5 ms
    for (ScriptedClient& robot : robots) answers(robot, *cast);
    broker.waits(60s);
    for (ScriptedClient& robot : robots) robot.hears_nothing();
    EXPECT_EQ(broker.core.census().queued, 0u);
    EXPECT_EQ(broker.core.counters().cell_repairs, 0u);
    broker.expects_mirror_to_agree();
}

TEST_F(OneCell, WhoDoesNotAnswerIsRepairedByUnicastWithDup) {
    publishes("go", Qos::at_least_once);
    const auto cast = hears_cast();
    ASSERT_TRUE(cast);
    for (int i = 1; i < 4; ++i) answers(robots[static_cast<std::size_t>(i)], *cast);
    broker.waits(2s);
    const auto repair = robots[0].hears_publish("go", Qos::at_least_once);
    EXPECT_TRUE(repair.dup);
    EXPECT_EQ(repair.msg_id, cast->msg_id);
    broker.waits(60s);
    for (ScriptedClient& robot : robots) robot.hears_nothing();
    EXPECT_EQ(broker.core.counters().cell_repairs, 1u);
    broker.expects_mirror_to_agree();
}

TEST_F(OneCell, WhoIsRepairedIsExceptedAndGetsTheNextInOrder) {  // P5
    publishes("1", Qos::at_least_once);
    const auto first = hears_cast();
    ASSERT_TRUE(first);
    for (int i = 1; i < 4; ++i) answers(robots[static_cast<std::size_t>(i)], *first);
    broker.waits(2s);
    publishes("2", Qos::at_least_once);
    const auto second = hears_cast();
    ASSERT_TRUE(second);
    EXPECT_EQ(second->behind, no_msg_id);
    EXPECT_FALSE(second->is_for(robots[0]));
    for (int i = 1; i < 4; ++i) {
        EXPECT_TRUE(second->is_for(robots[static_cast<std::size_t>(i)]));
        answers(robots[static_cast<std::size_t>(i)], *second);
    }
    robots[0].hears_publish("1", Qos::at_least_once);
    robots[0].hears_publish("2", Qos::at_least_once);
    robots[0].hears_nothing();
    broker.expects_mirror_to_agree();
}

TEST_F(OneCell, ABurstAtQos1IsOneDatagramEachAndOneAnswerForAll) {
    std::vector<Cast> burst;
    for (const char* data : {"1", "2", "3"}) {
        publishes(data, Qos::at_least_once);
        const auto cast = hears_cast();
        ASSERT_TRUE(cast);
        EXPECT_EQ(cast->behind, burst.empty() ? no_msg_id : burst.back().msg_id);
        EXPECT_TRUE(cast->exceptions.empty());
        burst.push_back(*cast);
        // Who has answered already goes on as well.
        if (burst.size() == 2) answers(robots[3], *cast);
    }
    broker.expects_mirror_to_agree();
    for (ScriptedClient& robot : robots) answers(robot, burst.back());
    broker.waits(60s);
    for (ScriptedClient& robot : robots) robot.hears_nothing();
    EXPECT_EQ(broker.core.census().queued, 0u);
    EXPECT_EQ(broker.core.counters().cell_publishes, 3u);
    EXPECT_EQ(broker.core.counters().cell_repairs, 0u);
    EXPECT_EQ(broker.dropped(Drop::unexpected), 0u);
    broker.expects_mirror_to_agree();
    publishes("4", Qos::at_least_once);
    EXPECT_EQ(hears_cast()->behind, no_msg_id);
}

TEST_F(OneCell, WhoMissedOneOfABurstGetsItAndAllBehindItByUnicastInOrder) {  // P2, P5
    std::vector<Cast> burst;
    for (const char* data : {"1", "2", "3"}) {
        publishes(data, Qos::at_least_once);
        burst.push_back(hears_cast().value());
    }
    answers(robots[0], burst[0]);
    for (int i = 1; i < 4; ++i) answers(robots[static_cast<std::size_t>(i)], burst[2]);
    broker.expects_mirror_to_agree();
    robots[0].hears_nothing();
    broker.waits(2s);
    const auto second = robots[0].hears_publish("2", Qos::at_least_once);
    EXPECT_TRUE(second.dup);
    EXPECT_EQ(second.msg_id, burst[1].msg_id);
    const auto third = robots[0].hears_publish("3", Qos::at_least_once);
    EXPECT_TRUE(third.dup);
    EXPECT_EQ(third.msg_id, burst[2].msg_id);
    EXPECT_EQ(broker.core.counters().cell_repairs, 2u);
    for (ScriptedClient& robot : robots) robot.hears_nothing();
    publishes("4", Qos::at_least_once);  // and then it is a listener as before
    EXPECT_TRUE(hears_cast()->is_for(robots[0]));
    broker.expects_mirror_to_agree();
}

TEST_F(OneCell, BeyondSixteenWithoutAnAnswerTheNextWaitsAndGoesByUnicast) {  // P8
    std::vector<Cast> burst;
    for (int i = 0; i < 17; ++i) {
        publishes("x", Qos::at_least_once);
        if (const auto cast = hears_cast()) burst.push_back(*cast);
    }
    ASSERT_EQ(burst.size(), 16u);
    for (ScriptedClient& robot : robots) {
        robot.hears_nothing();
        answers(robot, burst.back());
        EXPECT_FALSE(robot.hears_publish("x", Qos::at_least_once).dup);
        robot.hears_nothing();
    }
    broker.expects_mirror_to_agree();
}

TEST_F(OneCell, WhoWasToldAnotherOneLastIsNoPartOfTheBurst) {
    for (int i = 0; i < 2; ++i) {
        robots[static_cast<std::size_t>(i)].subscribes("pair", Qos::at_least_once);
    }
    publishes("1", Qos::at_least_once);
    const Cast first = hears_cast().value();
    publisher.publishes(publisher.registers("pair"), "2", Qos::at_least_once);
    const Cast second = hears_cast().value();
    EXPECT_EQ(second.behind, first.msg_id);
    publishes("3", Qos::at_least_once);  // two were told "2" last, two "1"
    const Cast third = hears_cast().value();
    EXPECT_EQ(third.behind, second.msg_id);
    EXPECT_TRUE(third.is_for(robots[1]));
    EXPECT_FALSE(third.is_for(robots[2]));
    answers(robots[2], first);
    robots[2].hears_publish("3", Qos::at_least_once);
    broker.expects_mirror_to_agree();
}

TEST_F(OneCell, ATakeOverSendsWhatABurstLeftOpenInOrder) {  // P2, P5
    std::vector<Cast> burst;
    for (const char* data : {"1", "2", "3"}) {
        publishes(data, Qos::at_least_once);
        burst.push_back(hears_cast().value());
    }
    answers(robots[0], burst[1]);
    BrokerOptions options = with_a_cell();
    options.log = {broker_id_of("b2"), 1};
    ScriptedBroker heir{options};
    for (SessionImage& image : broker.core.images()) {
        EXPECT_TRUE(heir.core.adopt(heir.now, std::move(image), {}, heir.actions));
    }
    heir.drain();
    for (ScriptedClient& robot : robots) robot.moves_to(heir);
    answers(robots[1], burst[2]);  // too late: the heir does not know of it
    for (int i = 1; i < 4; ++i) {
        ScriptedClient& robot = robots[static_cast<std::size_t>(i)];
        for (const char* data : {"1", "2"}) robot.hears_publish(data, Qos::at_least_once);
    }
    for (ScriptedClient& robot : robots) {
        robot.hears_publish("3", Qos::at_least_once);
        robot.hears_nothing();
    }
    EXPECT_EQ(heir.core.census().queued, 0u);
}

TEST_F(OneCell, WhoSleepsIsExcepted) {
    robots[0].says(Disconnect{.has_duration = true, .duration_s = 60});
    robots[0].hears<Disconnect>();
    publishes("x", Qos::at_most_once);
    const auto cast = hears_cast();
    ASSERT_TRUE(cast);
    EXPECT_EQ(cast->exceptions, std::vector{listener_number(robots[0].id)});
    robots[0].says(Pingreq{.client_id = robots[0].id});
    robots[0].hears_publish("x");
    robots[0].hears<Pingresp>();
}

TEST_F(OneCell, WhoPublishesThereWithoutASubscriptionIsExcepted) {
    publisher.subscribes(cell_topic, Qos::at_most_once);
    publishes("x", Qos::at_most_once);
    const auto cast = hears_cast();
    ASSERT_TRUE(cast);
    EXPECT_FALSE(cast->is_for(publisher));
    EXPECT_EQ(cast->exceptions.size(), 1u);
    publisher.hears_nothing();
}

TEST_F(OneCell, WhoWasGrantedALowerQosIsExceptedAndGetsThat) {  // 6.10c
    robots[0].subscribes("common", Qos::at_most_once);
    publishes("x", Qos::at_least_once);
    robots[0].hears_publish("x", Qos::at_most_once);
    const auto cast = hears_cast();
    ASSERT_TRUE(cast);
    EXPECT_FALSE(cast->is_for(robots[0]));
}

TEST_F(OneCell, AtQos2StaysUnicast) {
    for (ScriptedClient& robot : robots) robot.subscribes("common", Qos::exactly_once);
    publishes("x", Qos::exactly_once);
    EXPECT_FALSE(hears_cast());
    for (ScriptedClient& robot : robots) robot.hears_publish("x", Qos::exactly_once);
}

TEST_F(OneCell, AMessageForOneListenerIsAUnicast) {
    robots[0].subscribes("alone", Qos::at_least_once);
    publisher.publishes(publisher.registers("alone"), "x");
    robots[0].hears_publish("x");
    EXPECT_FALSE(hears_cast());
}

TEST_F(OneCell, BeyondSixteenExceptionsAllGetUnicasts) {
    std::deque<ScriptedClient> sleepers;
    for (int i = 0; i < 17; ++i) {
        sleepers.emplace_back(broker, "sleeper-" + std::to_string(i));
        sleepers.back().connects();
        sleepers.back().subscribes("common", Qos::at_most_once);
        sleepers.back().subscribes(cell_topic, Qos::at_most_once);
        sleepers.back().says(Disconnect{.has_duration = true, .duration_s = 60});
        sleepers.back().hears<Disconnect>();
        publishes("x", Qos::at_most_once);
        EXPECT_EQ(hears_cast().has_value(), i < 16);
    }
    for (ScriptedClient& robot : robots) robot.hears_publish("x");
}

TEST_F(OneCell, WhoHasSaidGoodbyeIsNoExceptionAnyMore) {
    std::deque<ScriptedClient> gone;
    for (int i = 0; i < 17; ++i) {
        gone.emplace_back(broker, "gone-" + std::to_string(i));
        gone.back().connects();
        gone.back().subscribes("common", Qos::at_most_once);
        gone.back().subscribes(cell_topic, Qos::at_most_once);
        gone.back().says(Disconnect{});
        gone.back().hears<Disconnect>();
    }
    publishes("x", Qos::at_most_once);
    const auto cast = hears_cast();
    ASSERT_TRUE(cast);
    EXPECT_TRUE(cast->exceptions.empty());
    broker.expects_mirror_to_agree();
}

TEST_F(OneCell, MsgIdsLieAheadOfAllThatAListenerWasGiven) {
    robots[2].subscribes("own", Qos::at_least_once);
    const TopicId own = publisher.registers("own");
    for (int i = 0; i < 5; ++i) {
        publisher.publishes(own, "x", Qos::at_least_once);
        robots[2].hears_publish("x", Qos::at_least_once);
    }
    publishes("y", Qos::at_least_once);
    const auto cast = hears_cast();
    ASSERT_TRUE(cast);
    EXPECT_EQ(cast->msg_id, MsgId{6});
    for (ScriptedClient& robot : robots) answers(robot, *cast);
    robots[0].subscribes("own", Qos::at_least_once);
    robots[2].says(Unsubscribe{robots[2].next_msg_id(), {TopicIdType::normal, "own", no_topic_id}});
    robots[2].hears<Unsuback>();
    publisher.publishes(own, "z", Qos::at_least_once);
    EXPECT_EQ(robots[0].hears_publish("z", Qos::at_least_once).msg_id, MsgId{7});
}

TEST_F(OneCell, AKeptSessionListensAgainOnlyWhenItsClientSaysSo) {
    for (ScriptedClient& robot : robots) {
        robot.says(Disconnect{});
        robot.hears<Disconnect>();
        robot.connects(false);
    }
    publishes("x", Qos::at_most_once);
    EXPECT_FALSE(hears_cast());
    broker.expects_mirror_to_agree();
}

TEST_F(OneCell, AProtectedClientCannotListenNorOneBehindAForwarderOrWithoutAnId) {
    ScriptedClient behind{broker, "behind"};
    behind.address.wireless_node_id = "protected:behind";
    behind.connects();
    behind.says(Subscribe{
        false, Qos::at_most_once, MsgId{1}, {TopicIdType::normal, cell_topic, no_topic_id}});
    EXPECT_EQ(behind.hears<Suback>().return_code, ReturnCode::not_supported);
    ScriptedClient sealed{broker, "sealed"};
    sealed.via.packets = Endpoint::Packets::sealed;
    sealed.connects();
    sealed.says(Subscribe{
        false, Qos::at_most_once, MsgId{1}, {TopicIdType::normal, cell_topic, no_topic_id}});
    EXPECT_EQ(sealed.hears<Suback>().return_code, ReturnCode::not_supported);
    ScriptedClient nameless{broker, ""};
    nameless.connects();
    nameless.says(Subscribe{
        false, Qos::at_most_once, MsgId{1}, {TopicIdType::normal, cell_topic, no_topic_id}});
    EXPECT_EQ(nameless.hears<Suback>().return_code, ReturnCode::not_supported);
}

/// One client may not read one topic.
class Hiding final : public Permissions {
public:
    bool may_publish(const Speaker&, std::string_view, Bytes) const override { return true; }
    bool may_publish_something(const Speaker&, std::string_view) const override { return true; }
    bool may_read(const Speaker& who, std::string_view topic) const override {
        return who.client_id != "robot-3" || topic != "secret";
    }
    Extent may_read_of(const Speaker& who, std::string_view filter) const override {
        return who.client_id == "robot-3" && filter == "secret" ? Extent::none : Extent::all;
    }
    std::string name_of(const Speaker& who) const override { return std::string{who.client_id}; }
};

TEST_F(OneCell, WhatNotAllListenersMayReadIsUnicast) {  // subscribed or not: all of them hear it
    const Hiding rights;
    broker.core.set_permissions(&rights);
    for (int i = 0; i < 3; ++i) {
        robots[static_cast<std::size_t>(i)].subscribes("secret", Qos::at_most_once);
    }
    publisher.publishes(publisher.registers("secret"), "x");
    EXPECT_FALSE(hears_cast());
    for (int i = 0; i < 3; ++i) robots[static_cast<std::size_t>(i)].hears_publish("x");
    publishes("y", Qos::at_most_once);
    EXPECT_TRUE(hears_cast());
}

TEST_F(OneCell, ATakeOverRepairsByUnicastUnderTheSameId) {  // P2
    publishes("go", Qos::at_least_once);
    const auto cast = hears_cast();
    ASSERT_TRUE(cast);
    answers(robots[0], *cast);
    BrokerOptions options = with_a_cell();
    options.log = {broker_id_of("b2"), 1};
    ScriptedBroker heir{options};
    for (SessionImage& image : broker.core.images()) {
        EXPECT_TRUE(heir.core.adopt(heir.now, std::move(image), {}, heir.actions));
    }
    heir.drain();
    for (ScriptedClient& robot : robots) robot.moves_to(heir);
    for (int i = 1; i < 4; ++i) {
        const auto repair =
            robots[static_cast<std::size_t>(i)].hears_publish("go", Qos::at_least_once);
        EXPECT_TRUE(repair.dup);
        EXPECT_EQ(repair.msg_id, cast->msg_id);
    }
    robots[0].hears_nothing();

    publisher.moves_to(heir);  // the heir goes on with the cell of that address
    publishes("next", Qos::at_least_once);
    const auto next = hears_cast(heir);
    ASSERT_TRUE(next);
    EXPECT_TRUE(next->exceptions.empty());
    EXPECT_NE(next->msg_id, cast->msg_id);
}

TEST_F(OneCell, EachServiceAddressHasACellOfItsOwn) {
    std::deque<ScriptedClient> elsewhere;
    for (int i = 0; i < 2; ++i) {
        elsewhere.emplace_back(broker, "elsewhere-" + std::to_string(i));
        elsewhere.back().via = loopback(9, 1883);
        elsewhere.back().connects();
        elsewhere.back().subscribes("common", Qos::at_most_once);
        elsewhere.back().subscribes(cell_topic, Qos::at_most_once);
    }
    publishes("x", Qos::at_most_once);
    EXPECT_TRUE(hears_cast());
    EXPECT_EQ(broker.core.counters().cell_publishes, 2u);
    const Origin other{loopback(9, 1883), ClientAddress{group, {}}};
    EXPECT_EQ(broker.inboxes[other].size(), 1u);
}

}  // namespace
}  // namespace romano::broker::cell_test
