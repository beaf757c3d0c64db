// Protected clients of a broker core: who speaks is who has the key, and nothing else gets in.

#include "broker/protection/protected_clients.h"

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "broker/core/broker_core.h"
#include "romano/mqttsn/codec.h"
#include "romano/protection/robot_end.h"
#include "tests/broker/ciphered_clients.h"

namespace romano::broker::protected_clients_test {
namespace {

using mqttsn::ReturnCode;
using protection::Refusal;
using protection::RobotKey;
using test::connect_as;
using test::endpoint;
using test::Octets;
using test::octets_of;
using test::ping;
using test::Sent;

Endpoint sealed(Endpoint address) {
    address.packets = Endpoint::Packets::sealed;
    return address;
}

const Endpoint service = sealed(endpoint(1, 1883));
const Endpoint plain_service = endpoint(1, 1884);
const Endpoint place = endpoint(10, 5000);
const Endpoint other_place = endpoint(11, 5000);
const RobotKey key_a{{0xA}};
const RobotKey key_b{{0xB}};

/// A client's end.
class Robot {
public:
    Robot(std::string_view id, const RobotKey& key, std::uint32_t stored = 0)
        : keys_(protection::direction_keys(key)), end_(keys_, id, stored) {}

    Octets seal(const Octets& message) {
        if (const auto bound = end_.reserve().to_store()) end_.reserve().on_stored(*bound);
        Octets packet(message.size() + protection::most_overhead);
        packet.resize(end_.seal(message, packet));
        return packet;
    }
    Octets open(Octets packet) {
        const Bytes message = end_.open(packet);
        return {message.begin(), message.end()};
    }

private:
    protection::DirectionKeys keys_;
    protection::RobotEnd end_;
};

/// A broker core behind its protected clients, as a shell composes them.
struct Broker {
    explicit Broker(std::uint8_t identity, ProtectedClients::Known known = {},
                    std::size_t answers_per_second = Limits{}.stranger_answers_per_second)
        : clients({identity}, 0, answers_per_second), core({}, 1) {
        const std::vector<ProtectedClient> all{{"a", key_a}, {"b", key_b}};
        clients.set_clients(all, known);
    }
    std::vector<Sent> take(const Endpoint& via, const Endpoint& from, const Octets& datagram) {
        Actions actions;
        const Bytes admitted = clients.admit(now, via, from, datagram, actions);
        if (clients.to_store()) clients.on_stored();
        if (!admitted.empty()) core.on_datagram(now, via, from, admitted, actions);
        if (const auto bound = clients.reserve().to_store()) clients.reserve().on_stored(*bound);
        clients.seal(actions);
        return test::sent_to_clients(actions);
    }
    std::uint64_t refused(Refusal why) const {
        return clients.counters().refused[static_cast<std::size_t>(why)];
    }

    ProtectedClients clients;
    BrokerCore core;
    Instant now{};
};

struct Protected : testing::Test {
    /// The message that the robot finds in the one answer; empty when there is none for it.
    Octets ask(Robot& robot, const Octets& message, const Endpoint& from = place) {
        const auto answers = broker.take(service, from, robot.seal(message));
        return answers.size() == 1 ? robot.open(answers[0].octets) : Octets{};
    }

    Broker broker{1};
    Robot a{"a", key_a};
    Robot b{"b", key_b};
};

const Octets accepted = octets_of(mqttsn::Connack{ReturnCode::accepted});
const Octets refused = octets_of(mqttsn::Connack{ReturnCode::not_supported});
const Octets pong = octets_of(mqttsn::Pingresp{});
const Octets gone = octets_of(mqttsn::Disconnect{false, 0});

TEST_F(Protected, AClientWithItsKeyIsServed) {
    EXPECT_EQ(ask(a, connect_as("a")), accepted);
    EXPECT_EQ(ask(a, ping), pong);
    EXPECT_EQ(broker.core.session_count(), 1U);
    EXPECT_EQ(broker.clients.counters().opened, 2U);
    EXPECT_EQ(broker.clients.counters().sealed, 2U);
}

TEST_F(Protected, NobodyConnectsInAnothersName) {
    EXPECT_EQ(ask(a, connect_as("b")), refused);
    EXPECT_EQ(ask(a, connect_as("")), refused);
    EXPECT_EQ(broker.core.session_count(), 0U);
    EXPECT_EQ(broker.clients.counters().foreign_client_id, 2U);
}

TEST_F(Protected, NobodyWakesAnothersSession) {
    ask(b, connect_as("b"));
    ask(b, octets_of(mqttsn::Disconnect{true, 60}));
    EXPECT_EQ(ask(a, octets_of(mqttsn::Pingreq{"b"}), other_place), Octets{});
    EXPECT_EQ(broker.clients.counters().foreign_client_id, 1U);
    EXPECT_EQ(ask(b, octets_of(mqttsn::Pingreq{"b"}), other_place), pong);
}

TEST_F(Protected, WhoSpeaksFromAnothersAddressIsAStrangerThere) {
    ask(b, connect_as("b"));
    EXPECT_EQ(ask(a, ping), gone) << "a's key, b's address: not b's session";
    EXPECT_EQ(ask(b, ping), pong);
    ask(a, octets_of(mqttsn::Disconnect{false, 0}));
    EXPECT_EQ(ask(b, ping), pong);
}

TEST_F(Protected, ForgedReplayedCutAndUnprotectedDatagramsAreDroppedAndCounted) {
    ask(a, connect_as("a"));
    const Octets good = a.seal(ping);
    for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
        Octets forged = good;
        forged[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
        EXPECT_TRUE(broker.take(service, place, forged).empty()) << bit;
    }
    for (std::size_t size = 0; size < good.size(); ++size) {
        EXPECT_TRUE(
            broker.take(service, place, Octets(good.begin(), good.begin() + long(size))).empty());
    }
    EXPECT_EQ(broker.clients.counters().opened, 1U);
    EXPECT_EQ(broker.take(service, place, good).size(), 1U);
    const std::uint64_t replayed = broker.refused(Refusal::replayed);
    EXPECT_TRUE(broker.take(service, place, good).empty());
    EXPECT_EQ(broker.refused(Refusal::replayed), replayed + 1);
    const std::uint64_t unprotected = broker.refused(Refusal::unprotected);
    EXPECT_TRUE(broker.take(service, place, connect_as("a")).empty());
    EXPECT_TRUE(broker.take(service, place, ping).empty());
    EXPECT_EQ(broker.refused(Refusal::unprotected), unprotected + 2);
    Robot stranger{"c", key_a};
    EXPECT_TRUE(broker.take(service, place, stranger.seal(connect_as("c"))).empty());
    EXPECT_GT(broker.refused(Refusal::unknown_sender), 1U);
    Robot liar{"b", key_a};
    EXPECT_TRUE(broker.take(service, place, liar.seal(connect_as("b"))).empty());
    EXPECT_GT(broker.refused(Refusal::bad_tag), 1U);
    EXPECT_EQ(broker.core.session_count(), 1U);
}

TEST_F(Protected, WhatTheBrokerSentDoesNotComeBack) {
    const auto answers = broker.take(service, place, a.seal(connect_as("a")));
    ASSERT_EQ(answers.size(), 1U);
    EXPECT_TRUE(broker.take(service, place, answers[0].octets).empty());
    EXPECT_EQ(broker.refused(Refusal::unknown_sender), 1U);
}

TEST_F(Protected, OnAPlainListenerNobodyIsAClientThatHasAKey) {
    ask(a, connect_as("a"));
    auto answers = broker.take(plain_service, place, connect_as("a"));
    ASSERT_EQ(answers.size(), 1U);
    EXPECT_EQ(answers[0].octets, refused);
    EXPECT_TRUE(broker.take(plain_service, place, octets_of(mqttsn::Pingreq{"a"})).empty());
    const auto forwarded = [](std::string_view node, const Octets& message) {
        return octets_of(mqttsn::Encapsulated{0, as_octets(node), message});
    };
    EXPECT_EQ(broker.take(plain_service, place, forwarded("7", connect_as("a"))).size(), 1U);
    EXPECT_TRUE(broker.take(plain_service, place, forwarded("protected:a", ping)).empty());
    EXPECT_EQ(broker.clients.counters().needs_protection, 4U);
    EXPECT_EQ(ask(a, ping), pong) << "it noticed nothing";

    answers = broker.take(plain_service, place, connect_as("anybody"));
    ASSERT_EQ(answers.size(), 1U);
    EXPECT_EQ(answers[0].octets, accepted);
    EXPECT_EQ(broker.take(plain_service, other_place, forwarded("7", connect_as("d"))).size(), 1U);
    EXPECT_EQ(broker.core.session_count(), 3U);
}

TEST_F(Protected, OnAPlainListenerWhoFloodsInTheNameOfAClientWithAKeyHearsFewAnswers) {
    Broker slow{2, {}, 20};
    std::uint16_t port = 0;
    const auto answers_to = [&](int flood, std::string_view id) {
        std::size_t answers = 0;
        for (int i = 0; i < flood; ++i) {
            answers += slow.take(plain_service, endpoint(77, ++port), connect_as(id)).size();
        }
        return answers;
    };
    EXPECT_EQ(answers_to(100, "a"), 2U) << "a tenth of a second's";
    EXPECT_EQ(slow.clients.counters().stranger_rate, 98U);
    EXPECT_EQ(slow.clients.counters().needs_protection, 2U);
    EXPECT_EQ(answers_to(100, ""), 100U) << "a swarm may come at once";
    slow.now += std::chrono::milliseconds{50};
    EXPECT_EQ(answers_to(10, "b"), 1U);
    EXPECT_EQ(slow.take(service, place, a.seal(connect_as("a"))).size(), 1U);
    EXPECT_EQ(slow.core.session_count(), 101U);
}

TEST_F(Protected, DiscoveryIsAHintAndNotProtected) {
    const auto answers = broker.take(service, place, octets_of(mqttsn::Searchgw{1}));
    ASSERT_EQ(answers.size(), 1U);
    const auto message = mqttsn::decode(answers[0].octets);
    ASSERT_TRUE(message);
    EXPECT_EQ(mqttsn::type_of(*message), mqttsn::MsgType::gwinfo);
}

TEST_F(Protected, AWithdrawnKeyOpensNothingAndNothingIsSealedForIt) {
    ask(a, connect_as("a"));
    ask(b, connect_as("b"));
    const std::vector<ProtectedClient> others{{"b", key_b}};
    broker.clients.set_clients(others, {});
    EXPECT_EQ(ask(a, ping), Octets{});
    EXPECT_EQ(broker.refused(Refusal::unknown_sender), 1U);
    EXPECT_EQ(ask(b, ping), pong) << "who stays is known as before";
    const std::vector<ProtectedClient> changed{{"a", key_b}, {"b", key_b}};
    broker.clients.set_clients(changed, {});
    EXPECT_EQ(ask(a, ping), Octets{});
    Robot again{"a", key_b};
    EXPECT_EQ(ask(again, connect_as("a")), accepted);
}

// --- several brokers

TEST_F(Protected, ASuccessorGoesOnWithoutAWordOfTheClientAndTakesNothingTwice) {
    ask(a, connect_as("a"));
    const Octets old = a.seal(ping);
    broker.take(service, place, old);

    Broker heir{2};
    heir.clients.on_told(broker.clients.to_tell());
    EXPECT_TRUE(broker.clients.to_tell().empty());
    auto image = *broker.core.image("a");
    Actions adopted;
    heir.core.adopt(Instant{}, image, {}, adopted);
    EXPECT_TRUE(heir.take(service, place, old).empty());
    EXPECT_EQ(heir.refused(Refusal::replayed), 1U);
    const auto answers = heir.take(service, place, a.seal(ping));
    ASSERT_EQ(answers.size(), 1U);
    EXPECT_EQ(a.open(answers[0].octets), pong);
}

TEST_F(Protected, ASuccessorCanSpeakBeforeItHearsTheClient) {
    ask(a, connect_as("a"));
    Broker heir{2};
    heir.clients.on_told(broker.clients.to_tell());
    Actions actions;
    heir.core.adopt(Instant{}, *broker.core.image("a"), {}, actions);
    actions.clear();
    for (int i = 0; i < 3; ++i) {  // the keep-alive ends, and it is asked whether it lives
        heir.core.on_tick(heir.core.next_wakeup(), actions);
    }
    if (const auto bound = heir.clients.reserve().to_store()) {
        heir.clients.reserve().on_stored(*bound);
    }
    heir.clients.seal(actions);
    std::size_t opened = 0;
    for (const Action& action : actions.list()) {
        const auto* send = std::get_if<Send>(&action);
        if (send == nullptr) continue;
        const Bytes octets = actions.octets(*send);
        opened += a.open({octets.begin(), octets.end()}).empty() ? 0U : 1U;
    }
    EXPECT_GE(opened, 1U);
}

TEST_F(Protected, WhatIsToldLateTakesNothingBack) {
    ask(a, connect_as("a"));
    Broker other{2};
    const auto early = broker.clients.to_tell();
    other.clients.on_told(early);
    const Octets newer = a.seal(ping);
    EXPECT_FALSE(other.take(service, place, newer).empty());
    other.clients.on_told(early);
    EXPECT_TRUE(other.take(service, place, newer).empty());
    EXPECT_EQ(other.refused(Refusal::replayed), 1U);
}

TEST_F(Protected, AfterACrashAPeerKnowsWhereInTheStoredBlockTheClientIs) {
    ask(a, connect_as("a"));
    const protection::Heard stored{protection::RunId{0}, protection::numbers_a_block};
    Broker restarted{1, [&](const protection::SenderId& sender) {
                         return sender == protection::sender_id("a") ? std::optional{stored}
                                                                     : std::nullopt;
                     }};
    EXPECT_TRUE(restarted.take(service, place, a.seal(ping)).empty()) << "it may be an old one";
    restarted.clients.tell_all();
    EXPECT_TRUE(restarted.clients.to_tell().empty()) << "others know better";
    restarted.clients.on_told(broker.clients.to_tell());
    restarted.clients.tell_all();
    EXPECT_EQ(restarted.clients.to_tell().size(), 1U);
    const Octets next = a.seal(ping);
    EXPECT_FALSE(restarted.take(service, place, next).empty());
    EXPECT_TRUE(restarted.take(service, place, next).empty());
}

TEST_F(Protected, WhoComesLaterIsToldOfAllWhoWereEverHeard) {
    ask(a, connect_as("a"));
    ask(b, connect_as("b"));
    EXPECT_EQ(broker.clients.to_tell().size(), 2U);
    broker.clients.tell_all();
    EXPECT_EQ(broker.clients.to_tell().size(), 2U);
    Broker third{3};
    third.clients.tell_all();
    EXPECT_TRUE(third.clients.to_tell().empty());
}

}  // namespace
}  // namespace romano::broker::protected_clients_test
