// Links between services in one process, over real TCP on loopback. A service that is destroyed
// closes its connections and its port, as the kernel does for a dying process.

#include "overlay/link/link_service.h"

#include <gmock/gmock.h>

#include <boost/asio/buffer.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <functional>
#include <list>
#include <memory>
#include <vector>

#include "overlay/link/hello.h"

namespace romano::link::link_service_test {
namespace {

using namespace std::chrono_literals;
using boost::asio::ip::tcp;
using broker::BrokerId;
using broker::LogId;
using election::Link;
using testing::ElementsAre;

constexpr LogId one{BrokerId{1}, 100};
constexpr LogId two{BrokerId{2}, 200};

Endpoint loopback() {
    Endpoint out;
    out.family = Endpoint::Family::ipv4;
    out.address = {127, 0, 0, 1};
    return out;
}

class LinkServiceTest : public testing::Test {
protected:
    using News = std::vector<std::pair<LogId, Link>>;

    std::unique_ptr<LinkService> start(const LogId& self, News& news) {
        auto service = std::make_unique<LinkService>(
            io, self,
            [&news](const LogId& process, Link link) { news.emplace_back(process, link); });
        EXPECT_FALSE(service->open(loopback()));
        return service;
    }
    bool run_until(const std::function<bool()>& done) {
        const auto deadline = std::chrono::steady_clock::now() + 10s;
        while (!done()) {
            if (std::chrono::steady_clock::now() > deadline) return false;
            io.restart();
            io.run_one_for(5ms);
        }
        return true;
    }
    /// Particulars are said once; heartbeats go on.
    void name_each_other() {
        a->on_address(two, b->address(), b->secret());
        b->on_address(one, a->address(), a->secret());
    }
    void heartbeats() {
        a->on_heartbeat(two.broker);
        b->on_heartbeat(one.broker);
    }
    void link_both() {
        a = start(one, news_of_a);
        b = start(two, news_of_b);
        name_each_other();
        ASSERT_TRUE(run_until([&] {
            heartbeats();
            return !news_of_a.empty() && !news_of_b.empty();
        }));
    }
    tcp::socket dial(const Endpoint& address) {
        tcp::socket socket(io);
        socket.connect({boost::asio::ip::address_v4::loopback(), address.port});
        return socket;
    }
    /// As `two` does that has this secret.
    static void answer(tcp::socket& socket, const Secret& secret) {
        const auto octets = std::make_shared<std::array<std::uint8_t, Hello::octets>>();
        boost::asio::async_read(socket, boost::asio::buffer(*octets),
                                [&socket, secret, octets](const auto& error, std::size_t) {
                                    if (error) return;
                                    const auto asked = decode(*octets, secret);
                                    const Nonce nonce = asked ? asked->nonce : Nonce{};
                                    *octets = encode({two, one, nonce}, secret);
                                    boost::asio::write(socket, boost::asio::buffer(*octets));
                                });
    }
    /// As `two` does; `one` answers.
    void greet(tcp::socket& socket) {
        auto hello = encode({.from = two, .to = one, .nonce = {7}}, a->secret());
        boost::asio::write(socket, boost::asio::buffer(hello));
        bool answered = false;
        boost::asio::async_read(socket, boost::asio::buffer(hello),
                                [&](const auto& error, std::size_t) { answered = !error; });
        ASSERT_TRUE(run_until([&] { return answered; }));
        EXPECT_EQ(decode(hello, a->secret()), (Hello{.from = one, .to = two, .nonce = {7}}));
    }
    /// True when the other side closes the connection.
    bool is_closed(tcp::socket& socket) {
        bool closed = false;
        char octet = 0;
        socket.async_read_some(boost::asio::buffer(&octet, 1),
                               [&](const auto& error, std::size_t) { closed = bool{error}; });
        return run_until([&] { return closed; });
    }

    boost::asio::io_context io{1};
    News news_of_a, news_of_b;
    std::unique_ptr<LinkService> a, b;
};

TEST_F(LinkServiceTest, BothSidesAreToldThatTheLinkIsUp) {
    link_both();
    EXPECT_THAT(news_of_a, ElementsAre(std::pair(two, Link::up)));
    EXPECT_THAT(news_of_b, ElementsAre(std::pair(one, Link::up)));
}

// Particulars come once, and heartbeats each few milliseconds.
TEST_F(LinkServiceTest, APeerThatDidNotKnowUsYetIsDialledAgainWhenItIsHeardAgain) {
    a = start(one, news_of_a);
    b = start(two, news_of_b);
    a->on_address(two, b->address(), b->secret());
    ASSERT_TRUE(run_until([&] { return b->counters().strangers == 1; }));
    b->on_address(one, a->address(), a->secret());
    ASSERT_TRUE(run_until([&] {
        a->on_heartbeat(two.broker);
        return !news_of_a.empty();
    }));
    EXPECT_EQ(news_of_a.back(), std::pair(two, Link::up));
}

TEST_F(LinkServiceTest, ADeadProcessIsALostLink) {
    link_both();
    b.reset();
    ASSERT_TRUE(run_until([&] { return news_of_a.size() == 2; }));
    EXPECT_EQ(news_of_a.back(), std::pair(two, Link::lost));
}

TEST_F(LinkServiceTest, ALostLinkIsToldOnceThoughBeaconsGoOn) {
    link_both();
    b.reset();
    ASSERT_TRUE(run_until([&] {
        a->on_heartbeat(two.broker);
        return a->counters().dialled >= 5;
    }));
    EXPECT_EQ(a->counters().lost, 1u);
}

TEST_F(LinkServiceTest, AConnectionThatIsCutBetweenLivingProcessesIsNoLoss) {
    // A peer that is the test: it takes connections, answers, and cuts the first one.
    tcp::acceptor acceptor(io, {boost::asio::ip::address_v4::loopback(), 0});
    Endpoint address = loopback();
    address.port = acceptor.local_endpoint().port();
    std::list<tcp::socket> taken;
    const Secret secret = sixteen_random_octets();
    std::function<void()> accept = [&] {
        acceptor.async_accept([&](const auto& error, tcp::socket socket) {
            if (error) return;
            taken.push_back(std::move(socket));
            answer(taken.back(), secret);
            accept();
        });
    };
    accept();
    a = start(one, news_of_a);
    a->on_address(two, address, secret);
    ASSERT_TRUE(run_until([&] { return news_of_a.size() == 1; }));
    taken.front().close();
    ASSERT_TRUE(run_until([&] { return news_of_a.size() == 2; }));
    EXPECT_THAT(news_of_a, ElementsAre(std::pair(two, Link::up), std::pair(two, Link::up)));
    acceptor.close();
}

// Who took the port of a dead broker, or stands between, does not make it live.
TEST_F(LinkServiceTest, WhoeverAnswersWithoutThePeersSecretIsNotThePeer) {
    tcp::acceptor acceptor(io, {boost::asio::ip::address_v4::loopback(), 0});
    Endpoint address = loopback();
    address.port = acceptor.local_endpoint().port();
    a = start(one, news_of_a);
    std::list<tcp::socket> taken;
    acceptor.async_accept([&](const auto& error, tcp::socket socket) {
        if (error) return;
        taken.push_back(std::move(socket));
        answer(taken.back(), sixteen_random_octets());
    });
    a->on_address(two, address, sixteen_random_octets());
    ASSERT_TRUE(run_until([&] { return a->counters().strangers == 1; }));
    EXPECT_THAT(news_of_a, testing::IsEmpty());
}

TEST_F(LinkServiceTest, ARestartedProcessIsANewLink) {
    link_both();
    b.reset();
    ASSERT_TRUE(run_until([&] { return news_of_a.size() == 2; }));
    const LogId again{two.broker, two.incarnation + 1};
    b = start(again, news_of_b);
    a->on_address(again, b->address(), b->secret());
    b->on_address(one, a->address(), a->secret());
    ASSERT_TRUE(run_until([&] {
        heartbeats();
        return news_of_a.size() == 3;
    }));
    EXPECT_EQ(news_of_a.back(), std::pair(again, Link::up));
}

TEST_F(LinkServiceTest, AnEarlierLifeOfAPeerIsNotDialled) {
    link_both();
    const auto dialled = a->counters().dialled;
    a->on_address({two.broker, two.incarnation - 1}, b->address(), b->secret());
    EXPECT_EQ(a->counters().dialled, dialled);
}

TEST_F(LinkServiceTest, StrangersAreDroppedAndCounted) {
    link_both();
    const LogId stranger{BrokerId{9}, 1};
    const Secret& secret = a->secret();
    Secret guessed = secret;
    guessed.front() ^= 1U;
    const std::vector<std::array<std::uint8_t, Hello::octets>> greetings = {
        {},                                                          // garbage
        encode({.from = stranger, .to = one, .nonce = {}}, secret),  // never heard
        encode({{two.broker, 1}, one, {}}, secret),                  // another process of a peer
        encode({two, {one.broker, 1}, {}}, secret),                  // to another process
        encode({.from = two, .to = one, .nonce = {}}, guessed),      // in a peer's name
        encode({.from = two, .to = one, .nonce = {}}, b->secret()),  // with what others know
    };
    std::uint64_t expected = 0;
    for (const auto& greeting : greetings) {
        auto socket = dial(a->address());
        boost::asio::write(socket, boost::asio::buffer(greeting));
        EXPECT_TRUE(is_closed(socket));
        EXPECT_EQ(a->counters().strangers, ++expected);
    }
}

TEST_F(LinkServiceTest, WhoeverSaysNothingIsDroppedAfterASecond) {
    link_both();
    auto socket = dial(a->address());
    EXPECT_TRUE(is_closed(socket));
    EXPECT_EQ(a->counters().strangers, 1u);
}

TEST_F(LinkServiceTest, WhoeverBabblesAfterTheHelloIsDropped) {
    link_both();
    b.reset();
    auto socket = dial(a->address());
    greet(socket);
    boost::asio::write(socket, boost::asio::buffer("more", 4));
    EXPECT_TRUE(is_closed(socket));
    EXPECT_EQ(a->counters().strangers, 1u);
}

// It lost its power: nobody closed what it had.
TEST_F(LinkServiceTest, APeerThatDialsAgainTakesOnePlaceOnly) {
    link_both();
    b.reset();
    std::list<tcp::socket> all;
    for (std::size_t i = 0; i < LinkService::most_guests + 10; ++i) {
        all.push_back(dial(a->address()));
        ASSERT_NO_FATAL_FAILURE(greet(all.back()));
    }
    EXPECT_EQ(a->counters().too_many, 0u);
    EXPECT_TRUE(is_closed(all.front()));
    all.back().non_blocking(true);
    char octet = 0;
    boost::system::error_code error;
    all.back().read_some(boost::asio::buffer(&octet, 1), error);
    EXPECT_EQ(error, boost::asio::error::would_block) << "the last one is held";
}

TEST_F(LinkServiceTest, ConnectionsAreBounded) {
    link_both();
    std::vector<tcp::socket> crowd;
    ASSERT_TRUE(run_until([&] {
        if (crowd.size() < LinkService::most_guests) crowd.push_back(dial(a->address()));
        return a->counters().too_many > 0;
    }));
}

}  // namespace
}  // namespace romano::link::link_service_test
