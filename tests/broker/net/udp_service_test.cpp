#include "broker/net/udp_service.h"

#include <gtest/gtest.h>
#include <poll.h>
#include <unistd.h>

#include <functional>
#include <numeric>
#include <string>

#include "broker/net/clock.h"
#include "broker/net/endpoint_text.h"

namespace romano::net::udp_service_test {
namespace {

using namespace std::chrono_literals;

Endpoint at(const char* text) {
    return *parse_endpoint(text);
}

/// A client's socket, blocking, with a deadline.
class Peer {
public:
    explicit Peer(const Endpoint& local) {
        const SocketAddress address = to_socket_address(local);
        socket_ = socket(address.any.sa_family, SOCK_DGRAM, 0);
        EXPECT_EQ(bind(socket_, &address.any, address.size), 0);
        SocketAddress got;
        got.size = sizeof(sockaddr_in6);
        getsockname(socket_, &got.any, &got.size);
        endpoint_ = to_endpoint(got);
    }
    ~Peer() { close(socket_); }
    Peer(const Peer&) = delete;
    Peer& operator=(const Peer&) = delete;

    [[nodiscard]] const Endpoint& endpoint() const { return endpoint_; }

    void send(const Endpoint& to, const std::string& text) const {
        const SocketAddress address = to_socket_address(to);
        EXPECT_EQ(sendto(socket_, text.data(), text.size(), 0, &address.any, address.size),
                  static_cast<ssize_t>(text.size()));
    }

    struct Received {
        std::string text;
        Endpoint from;
    };
    [[nodiscard]] std::optional<Received> receive() const {
        pollfd ready{.fd = socket_, .events = POLLIN, .revents = 0};
        if (poll(&ready, 1, 2000) != 1) return std::nullopt;
        std::string text(65'536, '\0');
        SocketAddress from;
        from.size = sizeof(sockaddr_in6);
        const ssize_t size = recvfrom(socket_, text.data(), text.size(), 0, &from.any, &from.size);
        if (size < 0) return std::nullopt;
        text.resize(static_cast<std::size_t>(size));
        return Received{std::move(text), to_endpoint(from)};
    }

private:
    int socket_ = -1;
    Endpoint endpoint_;
};

void add_send(broker::Actions& actions, const Endpoint& via, const Endpoint& to, Bytes octets) {
    const MutableBytes room = actions.reserve(octets.size());
    std::copy(octets.begin(), octets.end(), room.begin());
    const std::uint32_t offset = actions.commit(octets.size());
    actions.push(broker::Send{.via = via,
                              .to = {to, {}},
                              .offset = offset,
                              .size = static_cast<std::uint32_t>(octets.size())});
}

/// A broker that answers each datagram with the same octets.
class Echo : public DatagramHandler {
public:
    explicit Echo(boost::asio::io_context& io) : io_(io), udp(io, *this) {}

    void on_datagram(const Endpoint& via, const Endpoint& from, Bytes octets) override {
        last_via = via;
        ++datagrams;
        if (on_each) on_each();
        add_send(actions_, via, from, octets);
    }
    void on_batch_end() override {
        ++batches;
        udp.carry_out(actions_);
        actions_.clear();
    }

    Endpoint serve(const char* address, Bind bind = Bind::alone) {
        Endpoint bound;
        const auto error = udp.open(at(address), bind, &bound);
        EXPECT_FALSE(error) << error.message();
        return bound;
    }
    void run_until(const std::function<bool()>& done) {
        const auto deadline = std::chrono::steady_clock::now() + 5s;
        while (!done() && std::chrono::steady_clock::now() < deadline) io_.run_one_for(100ms);
        EXPECT_TRUE(done());
    }

    int datagrams = 0;
    int batches = 0;
    Endpoint last_via;
    std::function<void()> on_each;

private:
    boost::asio::io_context& io_;
    broker::Actions actions_;

public:
    UdpService udp;
};

struct UdpServiceTest : testing::Test {
    boost::asio::io_context io;
    Echo broker{io};
};

struct Families : UdpServiceTest, testing::WithParamInterface<const char*> {};

TEST_P(Families, AnswersADatagramFromTheAddressItWentTo) {
    const Endpoint service = broker.serve(GetParam());
    Endpoint any = service;
    any.port = 0;
    const Peer client(any);
    client.send(service, "hello");
    broker.run_until([&] { return broker.datagrams == 1; });
    const auto answer = client.receive();
    ASSERT_TRUE(answer);
    EXPECT_EQ(answer->text, "hello");
    EXPECT_EQ(answer->from, service);
    EXPECT_EQ(broker.last_via, service);
}

INSTANTIATE_TEST_SUITE_P(UdpService, Families, testing::Values("127.77.1.1:0", "[::1]:0"),
                         [](const auto& test) { return test.index == 0 ? "Ipv4" : "Ipv6"; });

TEST_F(UdpServiceTest, OnAllAddressesTheAnswerLeavesFromTheOneThatTheDatagramWentTo) {
    Endpoint service = broker.serve("0.0.0.0:0");
    service.address = at("127.77.5.6:1").address;
    const Peer client(at("127.77.1.2:0"));
    client.send(service, "where");
    broker.run_until([&] { return broker.datagrams == 1; });
    const auto answer = client.receive();
    ASSERT_TRUE(answer);
    EXPECT_EQ(answer->from, service);
    EXPECT_EQ(broker.last_via, service);
}

TEST_F(UdpServiceTest, OnAllIpv6AddressesToo) {
    Endpoint service = broker.serve("[::]:0");
    service.address = at("[::1]:1").address;
    const Peer client(at("[::1]:0"));
    client.send(service, "where");
    broker.run_until([&] { return broker.datagrams == 1; });
    const auto answer = client.receive();
    ASSERT_TRUE(answer);
    EXPECT_EQ(answer->from, service);
}

TEST_F(UdpServiceTest, AllIpv6AddressesLeaveTheSamePortOfIpv4ToOthers) {
    const Endpoint v6 = broker.serve("[::]:0");
    EXPECT_FALSE(broker.udp.open(at(("0.0.0.0:" + std::to_string(v6.port)).c_str()), Bind::alone));
}

// P3: a client that roamed is sent from its new address only after what it is sent from the former
// one: a PUBLISH behind its own PUBREL would be a new message.
TEST_F(UdpServiceTest, AClientGetsWhatSeveralAddressesSendItInOrder) {
    const Endpoint one = broker.serve("127.77.1.1:0");
    const Endpoint two = broker.serve("127.77.1.2:0");
    const Peer client(at("127.77.1.3:0"));
    const Peer other(at("127.77.1.4:0"));
    broker::Actions actions;
    add_send(actions, two, client.endpoint(), as_octets("publish"));
    add_send(actions, one, other.endpoint(), as_octets("other's"));
    add_send(actions, one, client.endpoint(), as_octets("pubrel"));
    add_send(actions, two, client.endpoint(), as_octets("next"));
    broker.udp.carry_out(actions);
    for (const char* text : {"publish", "pubrel", "next"}) {
        const auto received = client.receive();
        ASSERT_TRUE(received);
        EXPECT_EQ(received->text, text);
    }
    EXPECT_TRUE(other.receive());
}

TEST_F(UdpServiceTest, ServesSeveralAddresses) {
    const Endpoint one = broker.serve("127.77.1.1:0");
    const Endpoint two = broker.serve("127.77.1.2:0");
    const Peer client(at("127.77.1.3:0"));
    client.send(one, "1");
    client.send(two, "2");
    broker.run_until([&] { return broker.datagrams == 2; });
    EXPECT_TRUE(client.receive());
    EXPECT_TRUE(client.receive());
    EXPECT_EQ(broker.udp.addresses(), (std::vector{one, two}));
}

TEST_F(UdpServiceTest, AnEmptyDatagramAndTheLargestOneArriveWhole) {
    const Endpoint service = broker.serve("127.77.1.1:0");
    const Peer client(at("127.77.1.2:0"));
    std::string large(65'507, '\0');
    std::iota(large.begin(), large.end(), '\0');
    client.send(service, "");
    client.send(service, large);
    broker.run_until([&] { return broker.datagrams == 2; });
    EXPECT_EQ(client.receive().value().text, "");
    EXPECT_EQ(client.receive().value().text, large);
}

TEST_F(UdpServiceTest, ReadsWhatIsThereInOneBatch) {
    const Endpoint service = broker.serve("127.77.1.1:0");
    const Peer client(at("127.77.1.2:0"));
    for (int i = 0; i < 50; ++i) client.send(service, std::to_string(i));
    broker.run_until([&] { return broker.datagrams == 50; });
    EXPECT_EQ(broker.batches, 1);
    for (int i = 0; i < 50; ++i) EXPECT_EQ(client.receive().value().text, std::to_string(i));
}

TEST_F(UdpServiceTest, SendsMoreThanOneSystemCallTakes) {
    const Endpoint service = broker.serve("127.77.1.1:0");
    const Peer client(at("127.77.1.2:0"));
    broker::Actions actions;
    for (int i = 0; i < 200; ++i) {
        add_send(actions, service, client.endpoint(), as_octets(std::to_string(i)));
    }
    broker.udp.carry_out(actions);
    EXPECT_EQ(broker.udp.counters().sent, 200U);
    for (int i = 0; i < 200; ++i) ASSERT_EQ(client.receive().value().text, std::to_string(i));
}

TEST_F(UdpServiceTest, ADatagramThatCannotBeSentDoesNotStopThoseBehindIt) {
    const Endpoint service = broker.serve("127.77.1.1:0");
    const Peer client(at("127.77.1.2:0"));
    broker::Actions actions;
    add_send(actions, service, at("[::1]:5"), as_octets("another family"));
    add_send(actions, service, client.endpoint(), as_octets("fine"));
    broker.udp.carry_out(actions);
    EXPECT_EQ(client.receive().value().text, "fine");
    EXPECT_EQ(broker.udp.counters().send_failed, 1U);
}

TEST_F(UdpServiceTest, DropsAndCountsWhatWouldLeaveFromAnAddressThatIsNotServed) {
    broker::Actions actions;
    add_send(actions, at("127.77.1.1:9"), at("127.77.1.2:9"), as_octets("x"));
    broker.udp.carry_out(actions);
    EXPECT_EQ(broker.udp.counters().no_such_socket, 1U);
}

TEST_F(UdpServiceTest, NoticesThatAStrangerHasTheAddress) {
    const Endpoint service = broker.serve("127.77.1.1:0");
    Echo other(io);
    EXPECT_EQ(other.udp.open(service, Bind::alone), boost::system::errc::address_in_use);
}

TEST_F(UdpServiceTest, APeerMayBindBesideAndGetsTheDatagramsFromThenOn) {
    const Endpoint service = broker.serve("127.77.1.1:0");
    Echo heir(io);
    ASSERT_FALSE(heir.udp.open(service, Bind::beside));
    const Peer client(at("127.77.1.2:0"));
    client.send(service, "to the newest");
    heir.run_until([&] { return heir.datagrams == 1; });
    EXPECT_EQ(broker.datagrams, 0);
}

TEST_F(UdpServiceTest, ServedAnewBesideAPeerItGetsTheDatagramsAgain) {
    const Endpoint service = broker.serve("127.77.1.1:0");
    const Peer client(at("127.77.1.2:0"));
    client.send(service, "before");
    Echo heir(io);
    ASSERT_FALSE(heir.udp.open(service, Bind::beside));
    ASSERT_FALSE(broker.udp.open(service, Bind::beside));
    client.send(service, "after");
    broker.run_until([&] { return broker.datagrams == 2; });
    EXPECT_EQ(heir.datagrams, 0);
    EXPECT_EQ(broker.udp.addresses().size(), 1U);
    EXPECT_EQ(client.receive().value().text, "before");
    EXPECT_EQ(client.receive().value().text, "after");
}

TEST_F(UdpServiceTest, AnAddressThatWasGivenUpIsServedNoMore) {
    const Endpoint service = broker.serve("127.77.1.1:0");
    broker.udp.close(service);
    EXPECT_FALSE(broker.udp.serves(service));
    Echo other(io);
    EXPECT_FALSE(other.udp.open(service, Bind::alone));
}

TEST_F(UdpServiceTest, AnAddressMayBeGivenUpWhileItsDatagramsAreRead) {
    const Endpoint service = broker.serve("127.77.1.1:0");
    const Peer client(at("127.77.1.2:0"));
    for (int i = 0; i < 10; ++i) client.send(service, "x");
    broker.on_each = [&] { broker.udp.close(service); };
    broker.run_until([&] { return broker.datagrams > 0; });
    io.run_for(1ms);
    EXPECT_EQ(broker.datagrams, 1);
}

TEST_F(UdpServiceTest, ServingAnAddressTwiceIsServingItOnce) {
    const Endpoint service = broker.serve("127.77.1.1:0");
    EXPECT_FALSE(broker.udp.open(service, Bind::alone));
    EXPECT_EQ(broker.udp.addresses().size(), 1U);
}

TEST_F(UdpServiceTest, HearsTheDiscoveryGroupAndSpeaksToItAsItsServiceAddress) {
    const Endpoint service = broker.serve("127.77.1.1:0");
    const Endpoint group = at("225.77.1.1:18830");
    ASSERT_FALSE(broker.udp.join(group));
    Echo neighbour(io);
    neighbour.serve("127.77.1.2:0");
    ASSERT_FALSE(neighbour.udp.join(group));

    broker::Actions actions;
    const MutableBytes room = actions.reserve(3);
    std::ranges::fill(room, std::uint8_t{7});
    actions.push(broker::Multicast{.radius = 1, .offset = actions.commit(3), .size = 3});
    broker.udp.carry_out(actions);
    neighbour.run_until([&] { return neighbour.datagrams == 1; });
    EXPECT_EQ(neighbour.last_via, neighbour.udp.addresses().front());
    // The neighbour's echo went to the address that the multicast came from.
    broker.run_until([&] { return broker.last_via == service; });
}

// Such a group is a different one on each link: without a link there is none to join.
TEST_F(UdpServiceTest, JoinsAGroupOfIpv6LinksOnTheLinkOfItsServiceAddress) {
    broker.serve("[::1]:0");
    EXPECT_FALSE(broker.udp.join(at("[ff02::7777]:18831")));
}

// Without a route for multicasts too, as on a machine whose network comes later.
TEST_F(UdpServiceTest, ServesADiscoveryGroupOfIpv4OnAllAddresses) {
    broker.serve("0.0.0.0:0");
    EXPECT_FALSE(broker.udp.join(at("225.77.1.2:18833")));
}

TEST_F(UdpServiceTest, ServesADiscoveryGroupOfIpv6OnAllAddresses) {
    broker.serve("[::]:0");
    EXPECT_FALSE(broker.udp.join(at("[ff02::7777]:18832")));
}

TEST_F(UdpServiceTest, RefusesAGroupWithoutAServiceAddressOfItsFamily) {
    broker.serve("127.77.1.1:0");
    EXPECT_TRUE(broker.udp.join(at("[ff02::1]:18830")));
}

}  // namespace
}  // namespace romano::net::udp_service_test
