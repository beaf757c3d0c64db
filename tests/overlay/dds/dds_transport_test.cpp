#include "overlay/dds/dds_transport.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <boost/asio/executor_work_guard.hpp>
#include <functional>
#include <string>
#include <vector>

#include "overlay/dds/cluster_message.pb.h"
#include "tests/overlay/dds/test_domain.h"

namespace romano::dds::dds_transport_test {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

/// A broker's end of the transport that remembers what it received.
struct Peer {
    Peer(boost::asio::io_context& io, const Domain& domain, const char* name,
         std::uint64_t incarnation = 1, const overlay::Pulses& pulses = {1h, 1h})
        : log{broker::broker_id_of(name), incarnation},
          transport(
              io, domain, log, pulses, [this] { ++drains; },
              [this](std::uint64_t known) { later_life = known; }) {
        transport.start(
            [this](const overlay::Envelope& envelope) { received.push_back(envelope); });
    }

    void broadcast(cluster::ClusterMessage message) {
        transport.send({std::nullopt, std::move(message)});
    }
    void send(const Peer& to, cluster::ClusterMessage message) {
        transport.send({to.log.broker, std::move(message)});
    }
    template <typename M>
    [[nodiscard]] std::vector<M> all() const {
        std::vector<M> out;
        for (const auto& envelope : received) {
            if (const auto* message = std::get_if<M>(&envelope.message)) out.push_back(*message);
        }
        return out;
    }

    broker::LogId log;
    std::vector<overlay::Envelope> received;
    int drains = 0;
    std::uint64_t later_life = 0;
    DdsTransport transport;
};

cluster::Heartbeat heartbeat(std::uint64_t tick) {
    cluster::Heartbeat out;
    out.tick = tick;
    return out;
}

cluster::LogBatch batch(broker::Seq first_seq, std::size_t payload_octets = 0) {
    cluster::LogBatch out;
    out.first_seq = first_seq;
    if (payload_octets > 0) {
        broker::Message message;
        message.payload.resize(payload_octets);
        out.events.push_back(broker::Published{broker::MessagePtr{message}, "", {}, {}});
    }
    return out;
}

struct DdsTransportTest : testing::Test {
    void run_until(const std::function<bool()>& done, Clock::duration limit = 10s) {
        const auto deadline = Clock::now() + limit;
        while (!done() && Clock::now() < deadline) io.run_one_for(20ms);
        EXPECT_TRUE(done());
    }
    /// Both say things until each has heard the other: matching takes a few milliseconds.
    void acquaint(Peer& one, Peer& two) {
        const auto met = [](const Peer& a) {
            return !a.all<cluster::Heartbeat>().empty() && !a.all<cluster::LogBatch>().empty() &&
                   !a.all<cluster::LogAck>().empty();
        };
        const auto deadline = Clock::now() + 10s;
        while (!(met(one) && met(two)) && Clock::now() < deadline) {
            for (Peer* peer : {&one, &two}) {
                peer->broadcast(heartbeat(1));
                peer->broadcast(batch(0));
                peer->broadcast(cluster::LogAck{});
            }
            io.run_for(5ms);
        }
        ASSERT_TRUE(met(one) && met(two));
        io.run_for(50ms);  // the last hellos
        one.received.clear();
        two.received.clear();
    }

    TestDomain id;
    Domain domain{DomainOptions{id.id(), "lo"}};
    boost::asio::io_context io;
    boost::asio::executor_work_guard<boost::asio::io_context::executor_type> work{
        io.get_executor()};  // DDS posts from its own threads
};

TEST_F(DdsTransportTest, BeaconsReachEverybodyElse) {
    Peer one(io, domain, "one");
    Peer two(io, domain, "two");
    acquaint(one, two);
    one.broadcast(heartbeat(5));
    run_until([&] { return two.received.size() == 1; });
    EXPECT_EQ(two.received.front().from, one.log);
    EXPECT_EQ(two.all<cluster::Heartbeat>().front().tick, 5U);
    EXPECT_TRUE(one.received.empty());
}

TEST_F(DdsTransportTest, PulsesFollowABeaconWhileTheNextOneIsLate) {
    Peer one(io, domain, "one", 1, {10ms, 200ms});
    Peer two(io, domain, "two");
    acquaint(one, two);
    io.run_for(200ms);  // the pulses of the hellos
    two.received.clear();
    one.broadcast(heartbeat(7));
    run_until([&] { return two.all<cluster::Pulse>().size() >= 3; });
    EXPECT_EQ(two.all<cluster::Pulse>().front().tick, 7U);
    io.run_for(200ms);
    const std::size_t pulses = two.received.size();
    io.run_for(100ms);
    EXPECT_EQ(two.received.size(), pulses) << "for half a detection time and no longer";
}

TEST_F(DdsTransportTest, NoPulseFollowsTheLastBeacon) {
    Peer one(io, domain, "one", 1, {10ms, 200ms});
    Peer two(io, domain, "two");
    acquaint(one, two);
    cluster::Heartbeat last = heartbeat(9);
    last.leaving = true;
    one.broadcast(last);
    run_until([&] { return !two.all<cluster::Heartbeat>().empty(); });
    two.received.clear();
    io.run_for(150ms);
    EXPECT_TRUE(two.received.empty());
}

TEST_F(DdsTransportTest, LogBatchesArriveAllAndInOrder) {
    Peer one(io, domain, "one");
    Peer two(io, domain, "two");
    acquaint(one, two);
    constexpr broker::Seq count = 5000;
    for (broker::Seq seq = 1; seq <= count; ++seq) one.broadcast(batch(seq));
    run_until([&] { return two.received.size() == count; });
    const auto batches = two.all<cluster::LogBatch>();
    for (broker::Seq seq = 1; seq <= count; ++seq) ASSERT_EQ(batches[seq - 1].first_seq, seq);
    EXPECT_GT(two.drains, 0);
}

TEST_F(DdsTransportTest, OnlyTheAddresseeReadsItsInbox) {
    Peer one(io, domain, "one");
    Peer two(io, domain, "two");
    Peer three(io, domain, "three");
    acquaint(one, two);
    acquaint(one, three);
    const auto before = three.transport.counters().received;
    one.send(two, cluster::SessionRequest{"robot", {}});
    run_until([&] { return two.all<cluster::SessionRequest>().size() == 1; });
    EXPECT_EQ(two.all<cluster::SessionRequest>().front().client_id, "robot");
    EXPECT_EQ(three.transport.counters().received, before);
}

TEST_F(DdsTransportTest, DirectMessagesArriveInOrder) {
    Peer one(io, domain, "one");
    Peer two(io, domain, "two");
    acquaint(one, two);
    for (int i = 0; i < 1000; ++i) one.send(two, cluster::SessionRequest{std::to_string(i), {}});
    run_until([&] { return two.received.size() == 1000; });
    const auto requests = two.all<cluster::SessionRequest>();
    for (std::size_t i = 0; i < 1000; ++i) ASSERT_EQ(requests[i].client_id, std::to_string(i));
}

TEST_F(DdsTransportTest, WhatIsSaidBeforeThePeerIsReadyWaitsForIt) {
    Peer one(io, domain, "one");
    Peer two(io, domain, "two");
    // One hears of two and answers at once, although two cannot have matched its writer yet.
    const auto deadline = Clock::now() + 10s;
    while (one.received.empty() && Clock::now() < deadline) {
        two.broadcast(heartbeat(2));
        io.run_for(1ms);
    }
    ASSERT_FALSE(one.received.empty());
    one.send(two, cluster::SessionRequest{"first words", {}});
    run_until([&] { return !two.all<cluster::SessionRequest>().empty(); });
}

TEST_F(DdsTransportTest, ForwardsReachTheAddressee) {
    Peer one(io, domain, "one");
    Peer two(io, domain, "two");
    acquaint(one, two);
    broker::Message message;
    message.topic = "pose";
    const auto deadline = Clock::now() + 10s;
    while (two.received.empty() && Clock::now() < deadline) {  // best-effort: until matched
        one.send(two, cluster::ForwardBatch{{broker::MessagePtr{message}}});
        io.run_for(5ms);
    }
    ASSERT_FALSE(two.received.empty());
    EXPECT_EQ(two.all<cluster::ForwardBatch>().front().messages.front()->topic, "pose");
}

TEST_F(DdsTransportTest, LargeMessagesArriveWhole) {
    Peer one(io, domain, "one");
    Peer two(io, domain, "two");
    acquaint(one, two);
    for (broker::Seq seq = 1; seq <= 50; ++seq) one.broadcast(batch(seq, 65'000));
    run_until([&] { return two.received.size() == 50; });
    const auto batches = two.all<cluster::LogBatch>();
    EXPECT_EQ(std::get<broker::Published>(*batches.back().events.front()).message->payload.size(),
              65'000U);
}

TEST_F(DdsTransportTest, ARestartedPeerIsAddressedUnderItsNewIncarnation) {
    Peer one(io, domain, "one");
    {
        Peer two(io, domain, "two", 1);
        acquaint(one, two);
        one.send(two, cluster::SessionRequest{"old", {}});
        run_until([&] { return !two.received.empty(); });
    }
    Peer two(io, domain, "two", 2);
    acquaint(one, two);
    one.send(two, cluster::SessionRequest{"new", {}});
    run_until([&] { return !two.received.empty(); });
    EXPECT_EQ(two.all<cluster::SessionRequest>().size(), 1U);
    EXPECT_EQ(two.all<cluster::SessionRequest>().front().client_id, "new");
}

// It is heard by nobody: its machine's clock went back between two starts.
TEST_F(DdsTransportTest, ABrokerIsToldOfItsLaterLife) {
    Peer one(io, domain, "one");
    {
        Peer later(io, domain, "two", 9);
        acquaint(one, later);
    }
    {
        Peer earlier(io, domain, "two", 3);
        run_until([&] { return earlier.later_life != 0; });
        EXPECT_EQ(earlier.later_life, 9U);
    }
    Peer next(io, domain, "two", 10);
    acquaint(one, next);
    EXPECT_EQ(next.later_life, 0U);
    EXPECT_EQ(one.later_life, 0U);
}

TEST_F(DdsTransportTest, CountsWhatIsForAPeerThatWasNeverHeard) {
    Peer one(io, domain, "one");
    one.transport.send({broker::broker_id_of("nobody"), cluster::LogAck{}});
    EXPECT_EQ(one.transport.counters().unknown_peer, 1U);
}

TEST_F(DdsTransportTest, ABodyThatIsNoMessageIsDroppedAndCounted) {
    Peer one(io, domain, "one");
    const Entity participant = domain.make_participant();
    SampleWriter stranger(participant, "romano_log", reliable(100), {broker::BrokerId{9}, 1});
    const std::vector<std::uint8_t> garbage(100, 0xFF);
    const auto deadline = Clock::now() + 10s;
    while (one.transport.counters().malformed == 0 && Clock::now() < deadline) {
        stranger.write(garbage);
        stranger.write({});
        io.run_for(5ms);
    }
    EXPECT_GT(one.transport.counters().malformed, 0U);
    EXPECT_TRUE(one.received.empty());
}

// "Say so in the message that a broker of another version gets: both versions named."
TEST_F(DdsTransportTest, OfABrokerOfAnotherVersionPeopleAreToldOnce) {
    std::ostringstream said;
    const auto log = spdlog::default_logger();
    spdlog::set_default_logger(std::make_shared<spdlog::logger>(
        "", std::make_shared<spdlog::sinks::ostream_sink_mt>(said)));
    Peer one(io, domain, "one");
    const Entity participant = domain.make_participant();
    SampleWriter other(participant, "romano_beacon", best_effort(100), {broker::BrokerId{9}, 1});
    overlay::proto::ClusterMessage later;
    later.set_protocol(BodyCodec::protocol + 1);
    later.set_program_version("7.8.9");
    const std::string body = later.SerializeAsString();
    later.set_program_version("\x1b[31m");
    const std::string hostile = later.SerializeAsString();
    const auto deadline = Clock::now() + 10s;
    while (one.transport.counters().other_protocol < 5 && Clock::now() < deadline) {
        other.write(as_octets(hostile));
        other.write(as_octets(body));
        io.run_for(5ms);
    }
    spdlog::set_default_logger(log);
    EXPECT_GE(one.transport.counters().other_protocol, 5U);
    EXPECT_EQ(one.transport.counters().malformed, 0U);
    EXPECT_TRUE(one.received.empty());
    const std::string text = said.str();
    EXPECT_NE(text.find("a broker of version 7.8.9 is in this DDS domain, and this one of "
                        "version " ROMANO_VERSION " does not understand it"),
              std::string::npos)
        << text;
    EXPECT_EQ(std::ranges::count(text, '\n'), 1) << text;
    EXPECT_EQ(text.find('\x1b'), std::string::npos);
}

/// A dds_peer process whose output is read line by line; killed and reaped in the end.
class PeerProcess {
public:
    explicit PeerProcess(std::string argument) {
        int ends[2];
        EXPECT_EQ(pipe2(ends, O_CLOEXEC), 0);
        output_ = ends[0];
        posix_spawn_file_actions_t actions;
        posix_spawn_file_actions_init(&actions);
        posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
        // The kernel kills it when the test dies.
        std::vector<std::string> words{"/usr/bin/setpriv", "--pdeathsig", "KILL", DDS_PEER,
                                       std::move(argument)};
        std::vector<char*> argv;
        for (std::string& word : words) argv.push_back(word.data());
        argv.push_back(nullptr);
        EXPECT_EQ(posix_spawn(&pid_, argv[0], &actions, nullptr, argv.data(), environ), 0);
        posix_spawn_file_actions_destroy(&actions);
        close(ends[1]);
    }
    ~PeerProcess() {
        kill(pid_, SIGKILL);
        waitpid(pid_, nullptr, 0);
        close(output_);
    }
    PeerProcess(const PeerProcess&) = delete;
    PeerProcess& operator=(const PeerProcess&) = delete;

    void signal(int number) const { kill(pid_, number); }
    [[nodiscard]] bool said_something() const {
        pollfd ready{.fd = output_, .events = POLLIN, .revents = 0};
        return poll(&ready, 1, 0) == 1 && (ready.revents & POLLIN) != 0;
    }

private:
    pid_t pid_ = -1;
    int output_ = -1;
};

TEST_F(DdsTransportTest, AStoppedPeerBlocksNoWrite) {
    const PeerProcess stopped(std::to_string(id.id()));
    Peer one(io, domain, "one");
    const auto deadline = Clock::now() + 20s;
    while (!stopped.said_something() && Clock::now() < deadline) {
        one.broadcast(batch(1));
        io.run_for(5ms);
    }
    ASSERT_TRUE(stopped.said_something());
    stopped.signal(SIGSTOP);

    // Far more than any window of unacknowledged samples, and past the lease of the stopped peer.
    Clock::duration longest{};
    const auto end = Clock::now() + 1500ms;
    for (broker::Seq seq = 2; Clock::now() < end; ++seq) {
        const auto before = Clock::now();
        one.broadcast(batch(seq, 1000));
        one.transport.send({broker::broker_id_of("peer"), cluster::SessionRequest{"robot", {}}});
        longest = std::max(longest, Clock::now() - before);
        io.poll();
    }
    EXPECT_LT(longest, 300ms);  // blocking would last until the lease ends; noise is shorter
    EXPECT_EQ(one.transport.counters().write_failed, 0U);
    stopped.signal(SIGCONT);
}

TEST(Domain, RefusesAnInterfaceThatDoesNotExist) {
    const TestDomain id;
    EXPECT_THROW((void)Domain(DomainOptions{id.id(), "no-such-if"}).make_participant(), DdsError);
}

TEST(Domain, CanBeOpenedAgainAfterItWasClosed) {
    const TestDomain id;
    { const Domain domain(DomainOptions{id.id(), "lo"}); }
    const Domain domain(DomainOptions{id.id(), "lo"});
    EXPECT_NO_THROW((void)domain.make_participant());
}

}  // namespace
}  // namespace romano::dds::dds_transport_test
