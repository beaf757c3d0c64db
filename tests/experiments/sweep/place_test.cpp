// Networks and domains are taken once at a time, and free again when their holder dies.

#include "experiments/sweep/place.h"

#include <gtest/gtest.h>
#include <netinet/in.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>

namespace romano::experiments::place_test {
namespace {

// Nobody else's on this machine: other tests run at the same time.
std::string own_name() {
    return "test-" + std::to_string(::getpid());
}

TEST(Claims, HoldUntilTheyAreGivenUp) {
    {
        const auto claim = Claim::on_name(own_name());
        EXPECT_TRUE(claim);
        EXPECT_FALSE(Claim::on_name(own_name()));
        EXPECT_TRUE(Claim::on_name(own_name() + "-other"));
    }
    EXPECT_TRUE(Claim::on_name(own_name()));
}

TEST(Claims, EndWhenTheirHolderIsKilled) {
    const std::string name = own_name();
    std::array<int, 2> ends{};
    ASSERT_EQ(::pipe(ends.data()), 0);
    const pid_t holder = ::fork();
    if (holder == 0) {
        const auto claim = Claim::on_name(name);
        (void)!::write(ends[1], "x", 1);
        for (;;) ::pause();
    }
    char ready = 0;
    ASSERT_EQ(::read(ends[0], &ready, 1), 1);
    EXPECT_FALSE(Claim::on_name(name));
    ::kill(holder, SIGKILL);
    ::waitpid(holder, nullptr, 0);
    EXPECT_TRUE(Claim::on_name(name));
    ::close(ends[0]);
    ::close(ends[1]);
}

TEST(Networks, AreAnotherOneForEachSweep) {
    const auto first = claim_network("");
    const auto second = claim_network("");
    ASSERT_TRUE(first && second);
    EXPECT_NE(first->network, second->network);
    EXPECT_FALSE(claim_network(first->network));
}

TEST(Domains, AreAnotherOneForEachCell) {
    const auto first = claim_domain(182, 40, 5);
    const auto second = claim_domain(182, 40, 5);
    ASSERT_TRUE(first && second);
    EXPECT_NE(first->domain, second->domain);
    EXPECT_FALSE(claim_domain(first->domain, 1, 0));
}

TEST(Domains, InWhichSomebodySpeaksAreLeftAlone) {
    auto place = claim_domain(182, 40, 20);
    ASSERT_TRUE(place);
    const std::uint32_t domain = place->domain;
    place.reset();
    const int participant = ::socket(AF_INET, SOCK_DGRAM, 0);
    const int on = 1;
    ::setsockopt(participant, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(7400 + 250 * domain));
    ASSERT_EQ(::bind(participant, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    EXPECT_FALSE(claim_domain(domain, 1, 0));
    ::close(participant);
    EXPECT_TRUE(claim_domain(domain, 1, 0));
}

}  // namespace
}  // namespace romano::experiments::place_test
