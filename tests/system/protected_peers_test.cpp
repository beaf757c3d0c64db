// Brokers that prove themselves to each other by what `romano keys` made: who cannot, neither joins
// nor reads; and certificates are replaced and revoked while the cluster serves.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <linux/if_ether.h>
#include <linux/if_packet.h>
#include <net/if.h>
#include <signal.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <random>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "romano/keys/peer_papers.h"
#include "tests/system/protected_fleet.h"

namespace romano::system::protected_peers_test {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

constexpr const char* members = "romano_cluster_view_members";
constexpr const char* heard = "romano_cluster_transport_bytes_total{direction=\"received\"}";

struct ProtectedPeers : ProtectedFleet {
    ProtectedPeers() {
        EXPECT_EQ(romano({"keys", "new", fleet.string(), "--broker", "r3"}), 0) << said;
    }
    /// As the owner does it, with a folder on the broker's machine.
    void copy_to(const std::string& broker, const char* file) {
        fs::copy_file(keys.broker_folder(broker) / file, machine(broker) / file,
                      fs::copy_options::overwrite_existing);
    }
    [[nodiscard]] fs::path machine(const std::string& broker) const { return folder / broker; }
    void install(const std::string& broker) {
        fs::copy(keys.broker_folder(broker), machine(broker));
    }
    std::vector<std::string> member_of(int n, const fs::path& folder_of_keys) {
        return {"--listen",
                "protected://" + addresses.service(n),
                "--metrics",
                addresses.service(n),
                "--name",
                "r" + std::to_string(n),
                "--keys",
                folder_of_keys.string(),
                "--domain",
                std::to_string(addresses.domain()),
                "--interface",
                "lo",
                "--rank",
                std::to_string(n),
                "--detection-timeout-ms",
                "300"};
    }
    BrokerProcess& start(const std::vector<std::string>& arguments) {
        brokers.push_back(std::make_unique<BrokerProcess>(arguments));
        brokers.back()->wait_until_serving();
        return *brokers.back();
    }
    BrokerProcess& start_on_its_machine(int n) {
        return start(member_of(n, machine("r" + std::to_string(n))));
    }
    bool view_has(int broker, int count) {
        return metrics_come_to_say(addresses.service_endpoint(broker), members, count, count);
    }
    std::string refusal(const std::vector<std::string>& arguments) {
        Process broker(ROMANO_BROKER, arguments);
        EXPECT_EQ(broker.wait_for_exit(), 2);
        return broker.errors();
    }
};

TEST_F(ProtectedPeers, WhoHasNoPapersOrThoseOfAnotherFleetNeitherJoinsNorReads) {
    start_member(1);
    auto plain = member_of(4, keys.broker_folder("r3"));
    plain.insert(plain.end(), {"--plain-peers"});
    start(plain);
    keys::KeyFolder others(folder / "others");
    others.add({.brokers = {"r5"}, .robots = {}, .operators = {}});
    start(member_of(5, others.broker_folder("r5")));
    // Who came last has met everybody, if it ever will.
    start_member(2);
    ASSERT_TRUE(view_has(1, 2));
    EXPECT_TRUE(view_has(2, 2));
    const auto both = robot_that_hears_anna(mqttsn::Qos::at_least_once);
    ASSERT_TRUE(both.anna->publish(both.topic, "x", mqttsn::Qos::at_least_once));
    ASSERT_TRUE(both.robot->run_until([&] { return !both.robot->received.empty(); }));
    for (const int outsider : {4, 5}) {
        EXPECT_TRUE(view_has(outsider, 1)) << outsider;
        EXPECT_TRUE(metrics_come_to_say(addresses.service_endpoint(outsider), heard, 0, 0))
            << outsider;
    }
}

TEST_F(ProtectedPeers, ARevokedBrokerIsNotBelievedAfterARestart) {
    for (const char* name : {"r1", "r2", "r3"}) install(name);
    start_on_its_machine(2);
    start_on_its_machine(1);
    ASSERT_TRUE(view_has(1, 2));
    // r2 was stolen, and comes back when the others know it.
    ASSERT_EQ(romano({"keys", "withdraw", fleet.string(), "--broker", "r2"}), 0) << said;
    EXPECT_THAT(said, HasSubstr("revoked.pem"));
    copy_to("r1", keys::revoked_name);
    copy_to("r3", keys::revoked_name);
    for (const auto& broker : brokers) {
        broker->signal(SIGTERM);
        ASSERT_EQ(broker->wait_for_exit(), 0);
    }
    brokers.clear();
    start_on_its_machine(1);
    start_on_its_machine(2);
    start_on_its_machine(3);
    EXPECT_TRUE(view_has(1, 2)) << "with r3";
    EXPECT_TRUE(view_has(2, 1));
    EXPECT_TRUE(metrics_come_to_say(addresses.service_endpoint(2), heard, 0, 0));
    fs::copy_file(machine("r1") / keys::revoked_name, machine("r2") / keys::revoked_name,
                  fs::copy_options::overwrite_existing);
    brokers[1]->signal(SIGTERM);
    ASSERT_EQ(brokers[1]->wait_for_exit(), 0);
    EXPECT_THAT(refusal(member_of(2, machine("r2"))), HasSubstr("broker.pem: is revoked"));
}

TEST_F(ProtectedPeers, CertificatesAreReplacedOneBrokerAfterTheOtherUnderLoadAndNothingIsLost) {
    for (const char* name : {"r1", "r2", "r3"}) install(name);
    for (int n = 1; n <= 3; ++n) start_on_its_machine(n);
    ASSERT_TRUE(view_has(1, 3));
    const auto both = robot_that_hears_anna(mqttsn::Qos::exactly_once);
    const int begun = both.robot->sessions_begun + both.anna->sessions_begun;
    int published = 0;
    const auto publish = [&](int count) {
        for (int i = 0; i < count; ++i) {
            ASSERT_TRUE(both.anna->publish(both.topic, std::to_string(published++),
                                           mqttsn::Qos::exactly_once));
            both.robot->run_until([] { return false; }, std::chrono::milliseconds{2});
        }
    };
    publish(20);
    for (int n = 1; n <= 3; ++n) {
        const std::string name = "r" + std::to_string(n);
        ASSERT_EQ(romano({"keys", "renew", fleet.string(), name, "--days", "30"}), 0) << said;
        copy_to(name, keys::broker_certificate_name);
        copy_to(name, keys::permissions_name);
        brokers[0]->signal(SIGTERM);
        publish(10);
        ASSERT_EQ(brokers[0]->wait_for_exit(), 0);
        brokers.erase(brokers.begin());
        start_on_its_machine(n);
        publish(10);
        ASSERT_TRUE(view_has(n, 3)) << name;
    }
    ASSERT_TRUE(both.robot->run_until(
        [&] { return both.robot->received.size() == static_cast<std::size_t>(published); }));
    for (int i = 0; i < published; ++i) {
        EXPECT_EQ(both.robot->received[static_cast<std::size_t>(i)].data, std::to_string(i));
    }
    EXPECT_EQ(both.robot->sessions_begun + both.anna->sessions_begun, begun) << "a client noticed";
    EXPECT_EQ(romano({"keys", "check", machine("r1").string()}), 0) << said;
}

/// Whoever reaches the brokers' network: all that they say on loopback, heard and sent again.
class Eavesdropper {
public:
    Eavesdropper()
        : socket_(socket(AF_PACKET, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, htons(ETH_P_IP))) {
        sockaddr_ll loopback{};
        loopback.sll_family = AF_PACKET;
        loopback.sll_protocol = htons(ETH_P_IP);
        loopback.sll_ifindex = static_cast<int>(if_nametoindex("lo"));
        is_listening_ = socket_ >= 0 &&
                        bind(socket_, reinterpret_cast<sockaddr*>(&loopback), sizeof loopback) == 0;
    }
    ~Eavesdropper() { close(socket_); }
    Eavesdropper(const Eavesdropper&) = delete;
    Eavesdropper& operator=(const Eavesdropper&) = delete;

    /// False without the right to.
    [[nodiscard]] bool is_listening() const { return is_listening_; }
    void hear() {
        std::vector<std::uint8_t> frame(65536);
        for (;;) {
            const auto size = recv(socket_, frame.data(), frame.size(), 0);
            if (size <= 0) return;
            const Octets one(frame.begin(), frame.begin() + size);
            if (is_between_brokers(one)) frames.push_back(one);
        }
    }
    /// As it was, or bent, in a random order.
    void send_again(std::size_t times) {
        for (std::size_t i = 0; i < times; ++i) {
            Octets frame = frames[random_() % frames.size()];
            if (i % 2 == 1) {
                std::uint8_t& octet = frame[header + random_() % (frame.size() - header)];
                octet = static_cast<std::uint8_t>(octet ^ (1U << i % 8));
            }
            frame[checksum] = frame[checksum + 1] = 0;  // none
            (void)!send(socket_, frame.data(), frame.size(), 0);
            if (i % 256 == 0) usleep(1'000);
        }
    }

    using Octets = std::vector<std::uint8_t>;
    std::vector<Octets> frames;

private:
    static constexpr std::size_t checksum = 14 + 20 + 6;  // Ethernet, IPv4, UDP
    static constexpr std::size_t header = 14 + 20 + 8;

    [[nodiscard]] static bool is_between_brokers(const Octets& frame) {
        if (frame.size() < header + 4 || frame[14] != 0x45 || frame[23] != IPPROTO_UDP)
            return false;
        return std::ranges::equal(std::span{frame}.subspan(header, 4), std::string_view{"RTPS"});
    }

    int socket_;
    bool is_listening_ = false;
    std::mt19937 random_{1};
};

TEST_F(ProtectedPeers, WhatBrokersSaidIsNotReadAndChangesNothingWhenItIsPlayedBack) {
    Eavesdropper stranger;
    if (!stranger.is_listening()) GTEST_SKIP() << "without CAP_NET_RAW";
    start_both();
    const auto both = robot_that_hears_anna(mqttsn::Qos::exactly_once);
    const std::string secret = "the pose of a robot";
    const auto publish = [&] {
        ASSERT_TRUE(both.anna->publish(both.topic, secret, mqttsn::Qos::exactly_once));
    };
    for (int i = 0; i < 20; ++i) {
        publish();
        stranger.hear();
    }
    ASSERT_TRUE(both.robot->run_until([&] { return both.robot->received.size() == 20; }));
    ASSERT_GT(stranger.frames.size(), 20U);
    for (const auto& frame : stranger.frames) {
        EXPECT_EQ(std::ranges::search(frame, secret).begin(), frame.end());
    }
    const auto views = [&](int broker) {
        return metrics_come_to_say(addresses.service_endpoint(broker), "romano_cluster_views_total",
                                   0, 1);
    };
    ASSERT_TRUE(views(1) && views(2));
    stranger.send_again(50'000);
    publish();
    ASSERT_TRUE(both.robot->run_until([&] { return both.robot->received.size() == 21; }));
    for (int broker = 1; broker <= 2; ++broker) {
        EXPECT_TRUE(views(broker)) << "nobody was taken for dead";
        EXPECT_TRUE(view_has(broker, 2));
        EXPECT_TRUE(metrics_come_to_say(
            addresses.service_endpoint(broker),
            "romano_cluster_transport_refusals_total{reason=\"malformed\"}", 0, 0));
    }
    EXPECT_TRUE(both.robot->ping());
    EXPECT_EQ(both.robot->received.size(), 21U);
}

TEST_F(ProtectedPeers, AClientsCertificateIsNoBrokers) {
    install("r1");
    ASSERT_EQ(romano({"keys", "certificate", fleet.string(), "abcd1234"}), 0) << said;
    fs::copy_file(fleet / "certificates" / "abcd1234.pem",
                  machine("r1") / keys::broker_certificate_name,
                  fs::copy_options::overwrite_existing);
    EXPECT_THAT(refusal(member_of(1, machine("r1"))),
                AllOf(HasSubstr("--domain '"), HasSubstr("cannot be joined")));
}

TEST_F(ProtectedPeers, WhatIsWrongWithPapersIsOneSentence) {
    install("r1");
    const auto with = [&](const std::vector<std::string>& more) {
        auto arguments = member_of(1, machine("r1"));
        arguments.insert(arguments.end(), more.begin(), more.end());
        return arguments;
    };
    ASSERT_EQ(romano({"keys", "new", (folder / "others").string(), "--broker", "r1"}), 0) << said;
    const auto other = folder / "others" / "brokers" / "r1" / keys::authority_name;
    fs::copy_file(other, machine("r1") / keys::authority_name,
                  fs::copy_options::overwrite_existing);
    EXPECT_THAT(refusal(with({})), HasSubstr("is of another authority"));
    fs::permissions(machine("r1") / keys::authority_name, fs::perms::others_read,
                    fs::perm_options::add);
    EXPECT_THAT(refusal(with({})), HasSubstr("chmod 600"));
    fs::remove(machine("r1") / keys::authority_name);
    EXPECT_THAT(refusal(with({})),
                AllOf(HasSubstr("authority.pem: is missing"), HasSubstr("--plain-peers")));
    EXPECT_THAT(refusal({"--plain-peers", "--domain", "7"}), HasSubstr("--plain-peers is for"));
}

}  // namespace
}  // namespace romano::system::protected_peers_test
