#include "overlay/dds/body_codec.h"

#include <gtest/gtest.h>

#include <limits>

#include "overlay/dds/cluster_message_proto.h"
#include "tests/overlay/dds/field_count.h"
#include "tests/overlay/dds/random_message.h"

namespace romano::dds::body_codec_test {
namespace {

namespace proto = overlay::proto;

std::vector<std::uint8_t> copy(Bytes octets) {
    return {octets.begin(), octets.end()};
}

std::optional<cluster::ClusterMessage> decode(proto::ClusterMessage message) {
    BodyCodec codec;
    message.set_protocol(BodyCodec::protocol);
    return codec.decode(as_octets(message.SerializeAsString()));
}

// Whoever adds a field adds it to the .proto file, to its conversions and to random_message.cpp,
// and then here.
static_assert(field_count<Endpoint>() == 5);
static_assert(field_count<broker::Message>() == 7);
static_assert(field_count<broker::SessionHeader>() == 12);
static_assert(field_count<broker::Will>() == 4);
static_assert(field_count<broker::Subscription>() == 4);
static_assert(field_count<broker::TopicBinding>() == 3);
static_assert(field_count<broker::Delivery>() == 6);
static_assert(field_count<broker::SessionImage>() == 8);
static_assert(field_count<broker::SessionChanged>() == 2);
static_assert(field_count<broker::Published>() == 5);
static_assert(field_count<broker::Routed>() == 2);
static_assert(field_count<broker::Route>() == 3);
static_assert(field_count<broker::DeliveryStarted>() == 4);
static_assert(field_count<election::Rank>() == 3);
static_assert(field_count<election::Claim>() == 3);
static_assert(field_count<election::Ballot>() == 2);
static_assert(field_count<cluster::ViewNumber>() == 3);
static_assert(field_count<cluster::View>() == 2);
static_assert(field_count<cluster::Beacon>() == 23);
static_assert(field_count<cluster::Echo>() == 2);
static_assert(field_count<cluster::HeldByMember>() == 2);
static_assert(field_count<cluster::Heartbeat>() == 18);
static_assert(field_count<cluster::Usage>() == 4);
static_assert(field_count<cluster::Particulars>() == 3);
static_assert(field_count<cluster::Pulse>() == 2);
static_assert(field_count<cluster::LogBatch>() == 4);
static_assert(field_count<cluster::LogAck>() == 2);
static_assert(field_count<cluster::ViewProposal>() == 2);
static_assert(field_count<cluster::LeftAddress>() == 2);
static_assert(field_count<cluster::ViewHoldings>() == 8);
static_assert(field_count<cluster::Assignment>() == 3);
static_assert(field_count<cluster::ViewAnnouncement>() == 3);
static_assert(field_count<cluster::Fetch>() == 2);
static_assert(field_count<cluster::SnapshotPart>() == 10);
static_assert(field_count<cluster::SessionRequest>() == 2);
static_assert(field_count<cluster::Setting>() == 3);
static_assert(field_count<cluster::PacketsOfClient>() == 3);
static_assert(field_count<cluster::AssociationOfClient>() == 8);
static_assert(field_count<cluster::ProgressOfAssociation>() == 4);
static_assert(field_count<cluster::SecuredTold>() == 3);

// Two messages are equal when their octets are: encoding is deterministic. That no field is
// forgotten both ways is checked field by field below.
TEST(BodyCodec, EveryKindOfMessageSurvivesTheRoundTrip) {
    Random random{1};
    BodyCodec codec;
    for (int round = 0; round < 50; ++round) {
        for (std::size_t kind = 0; kind < message_kinds; ++kind) {
            const auto message = random_message(kind, random);
            ASSERT_EQ(message.index(), kind);
            const auto body = copy(codec.encode(message));
            const auto again = codec.decode(body);
            ASSERT_TRUE(again) << "kind " << kind;
            ASSERT_EQ(again->index(), kind);
            ASSERT_EQ(copy(codec.encode(*again)), body) << "kind " << kind;
        }
    }
}

TEST(BodyCodec, AHeartbeatKeepsItsFields) {
    Random random{2};
    BodyCodec codec;
    const auto message = random_message(0, random);
    const auto& in = std::get<cluster::Heartbeat>(message);
    const auto decoded = codec.decode(copy(codec.encode(message)));
    ASSERT_TRUE(decoded);
    const auto& out = std::get<cluster::Heartbeat>(*decoded);
    EXPECT_EQ(out.log, in.log);
    EXPECT_EQ(out.last_seq, in.last_seq);
    EXPECT_EQ(out.tick, in.tick);
    EXPECT_EQ(out.particulars, in.particulars);
    EXPECT_EQ(out.view, in.view);
    EXPECT_EQ(out.promised, in.promised);
    EXPECT_EQ(out.claim, in.claim);
    EXPECT_EQ(out.members, in.members);
    EXPECT_EQ(out.hears_members, in.hears_members);
    EXPECT_EQ(out.hears_others, in.hears_others);
    EXPECT_EQ(out.held, in.held);
    EXPECT_EQ(out.held_others, in.held_others);
    EXPECT_EQ(out.logs_held, in.logs_held);
    EXPECT_EQ(out.sessions, in.sessions);
    EXPECT_EQ(out.connected, in.connected);
    EXPECT_EQ(out.usage.transport_octets_sent, in.usage.transport_octets_sent);
    EXPECT_EQ(out.usage.transport_octets_received, in.usage.transport_octets_received);
    EXPECT_EQ(out.usage.longest_turn_us, in.usage.longest_turn_us);
    EXPECT_EQ(out.usage.cpu_percent, in.usage.cpu_percent);
    EXPECT_EQ(out.leaving, in.leaving);
}

TEST(BodyCodec, WantedParticularsSayNothingElse) {
    BodyCodec codec;
    const auto decoded = codec.decode(copy(codec.encode(cluster::Particulars{.wanted = true})));
    ASSERT_TRUE(decoded);
    EXPECT_TRUE(std::get<cluster::Particulars>(*decoded).wanted);
}

// A leader adds one to the highest that it has heard; and who counts members counts on their order.
TEST(BodyCodec, AViewThatNobodyCanHaveMadeIsMalformed) {
    const auto is_taken = [](const cluster::View& view) {
        BodyCodec codec;
        return codec.decode(copy(codec.encode(cluster::ViewProposal{view, {}}))).has_value();
    };
    const broker::LogId b1{broker::BrokerId{1}, 1};
    const broker::LogId b2{broker::BrokerId{2}, 1};
    const cluster::ViewNumber number{1, b1.broker, 1};
    EXPECT_TRUE(is_taken({number, {b1, b2}}));
    EXPECT_FALSE(is_taken({number, {b2, b1}}));
    EXPECT_FALSE(is_taken({number, {b1, b1}}));
    constexpr auto highest = std::numeric_limits<std::uint64_t>::max();
    EXPECT_FALSE(is_taken({{highest, b1.broker, 1}, {b1, b2}}));
    EXPECT_FALSE(is_taken({{1, b1.broker, highest}, {b1, b2}}));
}

TEST(BodyCodec, ATermThatNobodyCanHaveReachedIsMalformed) {
    constexpr auto highest = std::numeric_limits<std::uint64_t>::max();
    BodyCodec codec;
    const auto is_taken = [&](const cluster::ClusterMessage& message) {
        return codec.decode(copy(codec.encode(message))).has_value();
    };
    EXPECT_TRUE(is_taken(cluster::Heartbeat{}));
    EXPECT_FALSE(is_taken(cluster::Heartbeat{.promised = {highest, {}, 1}}));
    cluster::Heartbeat claims;
    claims.claim.term = highest;
    EXPECT_FALSE(is_taken(claims));
    EXPECT_TRUE(is_taken(cluster::ElectionMessage{}));
    EXPECT_FALSE(is_taken(cluster::ElectionMessage{{0, highest}}));
}

// Another name each time would be another topic each time (overlay/member/status_teller.h).
TEST(BodyCodec, ABrokerHasTheIdOfItsName) {
    BodyCodec codec;
    const auto is_taken = [&](const std::string& name, broker::BrokerId id) {
        const cluster::Beacon beacon{.name = name, .log = {id, 1}};
        return codec.decode(copy(codec.encode(cluster::Particulars{beacon, {}}))).has_value();
    };
    EXPECT_TRUE(is_taken("b1", broker::broker_id_of("b1")));
    EXPECT_FALSE(is_taken("b2", broker::broker_id_of("b1")));
}

TEST(BodyCodec, ParticularsKeepTheirFields) {
    Random random{2};
    BodyCodec codec;
    const auto message = random_message(12, random);
    const auto& in = std::get<cluster::Particulars>(message).beacon;
    const auto decoded = codec.decode(copy(codec.encode(message)));
    ASSERT_TRUE(decoded);
    const auto& out = std::get<cluster::Particulars>(*decoded).beacon;
    EXPECT_EQ(out.name, in.name);
    EXPECT_EQ(out.log, in.log);
    EXPECT_EQ(out.last_seq, in.last_seq);
    EXPECT_EQ(out.tick, in.tick);
    EXPECT_EQ(out.view, in.view);
    EXPECT_EQ(out.promised, in.promised);
    EXPECT_EQ(out.claim.rank, in.claim.rank);
    EXPECT_EQ(out.claim.term, in.claim.term);
    EXPECT_EQ(out.claim.leader, in.claim.leader);
    EXPECT_EQ(out.hears, in.hears);
    EXPECT_EQ(out.applied, in.applied);
    EXPECT_EQ(out.home_addresses, in.home_addresses);
    EXPECT_EQ(out.serving, in.serving);
    EXPECT_EQ(out.sessions, in.sessions);
    EXPECT_EQ(out.connected, in.connected);
    EXPECT_EQ(out.cannot_take, in.cannot_take);
    EXPECT_EQ(out.usage.transport_octets_sent, in.usage.transport_octets_sent);
    EXPECT_EQ(out.usage.transport_octets_received, in.usage.transport_octets_received);
    EXPECT_EQ(out.usage.longest_turn_us, in.usage.longest_turn_us);
    EXPECT_EQ(out.usage.cpu_percent, in.usage.cpu_percent);
    EXPECT_EQ(out.leaving, in.leaving);
    EXPECT_EQ(out.link, in.link);
    EXPECT_EQ(out.settings, in.settings);
    EXPECT_EQ(out.predefined, in.predefined);
}

TEST(BodyCodec, ASessionImageKeepsItsFields) {
    Random random{3};
    BodyCodec codec;
    for (int round = 0; round < 20; ++round) {
        const auto message = random_message(9, random);
        const auto& part = std::get<cluster::SnapshotPart>(message);
        const auto decoded = codec.decode(copy(codec.encode(message)));
        ASSERT_TRUE(decoded);
        const auto& out = std::get<cluster::SnapshotPart>(*decoded);
        EXPECT_EQ(out.last, part.last);
        ASSERT_EQ(out.sessions.size(), part.sessions.size());
        for (std::size_t i = 0; i < out.sessions.size(); ++i) {
            const auto& a = out.sessions[i];
            const auto& b = part.sessions[i];
            EXPECT_EQ(a.header, b.header);
            EXPECT_EQ(a.will, b.will);
            EXPECT_EQ(a.subscriptions, b.subscriptions);
            EXPECT_EQ(a.topics, b.topics);
            EXPECT_EQ(a.unreleased, b.unreleased);
            EXPECT_EQ(a.worked_through, b.worked_through);
            EXPECT_EQ(a.last_msg_id, b.last_msg_id);
            ASSERT_EQ(a.deliveries.size(), b.deliveries.size());
            for (std::size_t j = 0; j < a.deliveries.size(); ++j) {
                const auto& x = a.deliveries[j];
                const auto& y = b.deliveries[j];
                EXPECT_EQ(x.position, y.position);
                EXPECT_EQ(x.qos, y.qos);
                EXPECT_EQ(x.retain, y.retain);
                EXPECT_EQ(x.stage, y.stage);
                EXPECT_EQ(x.msg_id, y.msg_id);
                ASSERT_EQ(bool{x.message}, bool{y.message});
                if (!x.message) continue;
                EXPECT_EQ(x.message->topic, y.message->topic);
                EXPECT_EQ(x.message->payload, y.message->payload);
                EXPECT_EQ(x.message->qos, y.message->qos);
                EXPECT_EQ(x.message->retain, y.message->retain);
                EXPECT_EQ(x.message->position, y.message->position);
                EXPECT_EQ(x.message->published_at, y.message->published_at);
                EXPECT_EQ(x.message->origin, y.message->origin);
            }
        }
    }
}

TEST(BodyCodec, GarbageGivesNothingOrAMessageAndNeverACrash) {
    Random random{4};
    BodyCodec codec;
    for (int round = 0; round < 20'000; ++round) {
        std::vector<std::uint8_t> body(random.below(200));
        for (auto& octet : body) octet = static_cast<std::uint8_t>(random.below(256));
        (void)codec.decode(body);
    }
}

TEST(BodyCodec, EveryTruncationAndSingleFlipIsSurvived) {
    Random random{5};
    BodyCodec codec;
    for (std::size_t kind = 0; kind < message_kinds; ++kind) {
        auto body = copy(codec.encode(random_message(kind, random)));
        for (std::size_t size = 0; size < body.size(); ++size) {
            (void)codec.decode(Bytes{body}.first(size));
        }
        for (int flip = 0; flip < 300 && !body.empty(); ++flip) {
            auto changed = body;
            changed[random.below(static_cast<std::uint32_t>(body.size()))] ^=
                static_cast<std::uint8_t>(1U << random.below(8));
            (void)codec.decode(changed);
        }
    }
}

TEST(BodyCodec, AnEmptyBodyIsNoMessage) {
    BodyCodec codec;
    EXPECT_FALSE(codec.decode({}));
}

TEST(BodyCodec, AMessageOfALaterVersionIsDropped) {
    // Field 2000, length-delimited, empty: no alternative that is known here.
    const std::vector<std::uint8_t> body = {0x82, 0x7D, 0x00};
    BodyCodec codec;
    EXPECT_FALSE(codec.decode(body));
}

TEST(BodyCodec, AMessageOfAnotherProtocolIsNotReadAndNamesItsVersion) {
    proto::ClusterMessage message;
    message.mutable_heartbeat();
    message.set_program_version("7.8.9");
    BodyCodec codec;
    ASSERT_TRUE(decode(message));
    for (const std::uint32_t protocol : {0U, BodyCodec::protocol + 1, 0xFFFFFFFFU}) {
        message.set_protocol(protocol);
        const std::string body = message.SerializeAsString();
        EXPECT_FALSE(codec.decode(as_octets(body)));
        EXPECT_EQ(codec.version_of_other_protocol(as_octets(body)), "7.8.9");
    }
    message.clear_protocol();
    message.clear_program_version();
    const std::string earlier = message.SerializeAsString();
    EXPECT_EQ(codec.version_of_other_protocol(as_octets(earlier)), "0");
    EXPECT_FALSE(codec.version_of_other_protocol(codec.encode(cluster::Heartbeat{})));
    EXPECT_FALSE(codec.version_of_other_protocol(std::vector<std::uint8_t>(9, 0xFF)));
}

TEST(BodyCodec, RefusesAnAddressThatIsNoIpAddress) {
    proto::ClusterMessage message;
    auto& sealed = *message.mutable_log_batch()->add_events()->mutable_sealed();
    sealed.mutable_address()->set_address("12345");
    EXPECT_FALSE(decode(message));
    sealed.mutable_address()->set_address("1234");
    EXPECT_TRUE(decode(message));
    sealed.mutable_address()->set_port(0x10000);
    EXPECT_FALSE(decode(message));
}

TEST(BodyCodec, RefusesValuesOutOfRange) {
    proto::ClusterMessage batch;
    auto& event = *batch.mutable_log_batch()->add_events();
    event.mutable_session_changed()->mutable_header()->set_state(4);
    EXPECT_TRUE(decode(batch));
    event.mutable_session_changed()->mutable_header()->set_state(5);
    EXPECT_FALSE(decode(batch));
    event.mutable_publish_released()->set_msg_id(0x10000);
    EXPECT_FALSE(decode(batch));
    event.mutable_publish_released()->set_msg_id(0xFFFF);
    EXPECT_TRUE(decode(batch));
    event.mutable_subscribed()->mutable_subscription()->set_granted(3);
    EXPECT_FALSE(decode(batch));
    event.mutable_subscribed()->mutable_subscription()->set_granted(2);
    EXPECT_TRUE(decode(batch));
    event.mutable_subscribed()->mutable_subscription()->set_type(3);
    EXPECT_FALSE(decode(batch));

    proto::ClusterMessage ballot;
    ballot.mutable_ballot()->set_kind(256);
    EXPECT_FALSE(decode(ballot));
}

TEST(BodyCodec, RefusesAHeartbeatThatHoldsMoreLogsThanPositions) {
    proto::ClusterMessage message;
    auto& heartbeat = *message.mutable_heartbeat();
    heartbeat.add_held_members(0);
    heartbeat.add_held_members(1);
    heartbeat.add_held_through(300);
    EXPECT_FALSE(decode(message));
    heartbeat.add_held_through(7);
    EXPECT_TRUE(decode(message));
}

TEST(BodyCodec, RefusesACursorThatNamesMoreLogsThanPositions) {
    proto::ClusterMessage batch;
    auto& cursor = *batch.mutable_log_batch()->add_events()->mutable_cursor();
    cursor.add_brokers(1);
    cursor.add_incarnations(1);
    EXPECT_FALSE(decode(batch));
    cursor.add_through(300);
    EXPECT_TRUE(decode(batch));
    cursor.add_incarnations(2);
    EXPECT_FALSE(decode(batch));
}

TEST(BodyCodec, RefusesAnEventWithoutContent) {
    proto::ClusterMessage batch;
    batch.mutable_log_batch()->add_events();
    EXPECT_FALSE(decode(batch));
}

TEST(BodyCodec, RefusesAPublishWithoutItsMessage) {
    proto::ClusterMessage batch;
    batch.mutable_log_batch()->add_events()->mutable_published()->set_publisher("p");
    EXPECT_FALSE(decode(batch));
}

TEST(BodyCodec, CarriesTheLargestPayload) {
    BodyCodec codec;
    broker::Message message;
    message.topic = "t";
    message.payload.assign(65'498, 7);
    const auto decoded =
        codec.decode(copy(codec.encode(cluster::ForwardBatch{{broker::MessagePtr{message}}})));
    ASSERT_TRUE(decoded);
    EXPECT_EQ(std::get<cluster::ForwardBatch>(*decoded).messages.front()->payload, message.payload);
}

}  // namespace
}  // namespace romano::dds::body_codec_test
