#include "experiments/testbed/doctor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "experiments/testbed/host/network_cut.h"

namespace romano::experiments::doctor_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;

class Doctor : public ::testing::Test {
protected:
    Doctor() {
        for (const std::string number : {"1", "2"}) {
            Host host;
            host.name = "pi" + number;
            host.addresses = {"10.0.0.10" + number};
            testbed.hosts.push_back(host);
            HostFacts facts;
            facts.version = "1 (abc)";
            facts.architecture = "aarch64";
            facts.does_broker_run = true;
            facts.broker_digest = "77";
            facts.may_add_addresses = facts.may_announce = facts.may_cut = true;
            facts.has_interface = facts.is_up = facts.can_multicast = true;
            facts.mtu_octets = 1500;
            facts.own_addresses = {"10.0.0." + number};
            facts.addresses = {{host.addresses[0], false, true, ""}};
            facts.free_mib = 5000;
            HostSeen healthy;
            healthy.facts = facts;
            healthy.clock_offset_s = 0.1;
            healthy.longest_octets = 1472;
            healthy.heard = {{number == "1" ? "pi2" : "pi1", 1472}};
            seen.push_back(healthy);
        }
    }
    [[nodiscard]] std::vector<HostFinding> findings() const {
        return findings_of(testbed, seen, "1 (abc)");
    }
    [[nodiscard]] HostFacts& facts() { return *seen[1].facts; }

    Testbed testbed;
    std::vector<HostSeen> seen;
};

TEST_F(Doctor, FindsNothingAtHealthyHosts) {
    EXPECT_THAT(to_text(findings()), IsEmpty());
    EXPECT_FALSE(has_problem(findings()));
}

// Named so that each rule of the doctor has one case that only it finds.
class Ill : public Doctor {
public:
    void expect_one(const char* about, const char* sentence, bool is_problem = true) {
        const auto found = findings();
        ASSERT_THAT(found, SizeIs(1)) << to_text(found);
        EXPECT_EQ(found[0].host, "pi2");
        EXPECT_EQ(found[0].about, about);
        EXPECT_THAT(found[0].sentence, HasSubstr(sentence));
        EXPECT_EQ(found[0].is_problem, is_problem);
    }
};

TEST_F(Ill, HasNoRoomForTraces) {
    facts().free_mib = 12;
    expect_one("disk", "/tmp has 12 MiB free");
}

TEST_F(Ill, HasAClockThatIsWrongBeyondDoubt) {
    seen[1].clock_offset_s = -86'400;
    expect_one("clock", "86400.0 s behind this machine's", false);
    seen[1].clock_uncertainty_s = 90'000;
    EXPECT_THAT(findings(), IsEmpty()) << "the way there took longer";
}

TEST_F(Ill, HasNoSuchInterface) {
    facts().has_interface = facts().is_up = false;
    expect_one("interface", "it has no interface `eth0`");
}

TEST_F(Ill, HasAnInterfaceThatIsDown) {
    facts().is_up = false;
    expect_one("interface", "`eth0` is down");
}

TEST_F(Ill, HasNoAddressOfItsOwn) {
    facts().own_addresses.clear();
    expect_one("interface", "no address of its own");
}

TEST_F(Ill, MayNotAddAddresses) {
    facts().may_add_addresses = false;
    expect_one("rights", "CAP_NET_ADMIN");
}

TEST_F(Ill, MayNotAnnounceThem) {
    facts().may_announce = false;
    expect_one("rights", "CAP_NET_RAW");
}

TEST_F(Ill, CannotBeCutOffWithoutNft) {
    facts().may_cut = false;
    expect_one("rights", "sudo apt install nftables", false);
}

TEST_F(Ill, HasTheServiceAddressItself) {
    facts().addresses[0].is_own = true;
    expect_one("address", "10.0.0.102 is the machine's own");
}

TEST_F(Ill, IsInAnotherNetworkThanItsServiceAddress) {
    facts().addresses[0].is_in_network = false;
    expect_one("address", "choose one beside 10.0.0.2");
}

TEST_F(Ill, FindsItsServiceAddressTaken) {
    facts().addresses[0].neighbour = "aa:bb:cc:dd:ee:ff";
    expect_one("address", "answered by another machine already (aa:bb:cc:dd:ee:ff)");
}

TEST_F(Ill, FindsItsPortTaken) {
    facts().port_user = "romano-broker (process 312)";
    expect_one("port", "in use by romano-broker (process 312)");
}

// Whose own brokers serve port and address: one word about that is enough.
TEST_F(Ill, IsTakenByATestbed) {
    facts().taken_by = "romano testbed start";
    facts().port_user = "romano-broker-member (process 312)";
    facts().addresses[0].neighbour = "aa:bb:cc:dd:ee:ff";
    expect_one("use", "romano testbed stop HOSTS", false);
}

TEST_F(Ill, HasOtherPrograms) {
    facts().version = "0 (old)";
    expect_one("version", "its programs are 0 (old), and this one is 1 (abc)");
}

TEST_F(Ill, HasABrokerOfAnotherBuild) {
    facts().broker_digest = "78";
    expect_one("version", "its broker is another");
    facts().architecture = "x86_64";
    EXPECT_THAT(findings(), IsEmpty()) << "programs for another processor are other octets";
}

TEST_F(Ill, LacksALibrary) {
    facts().does_broker_run = false;
    facts().broker_version = "libddsc.so.0: cannot open shared object file";
    expect_one("programs", "does not run there: libddsc.so.0");
}

TEST_F(Ill, HasSettingsThatMustBeTheSame) {
    testbed.hosts[0].broker_options = {"--rank", "1", "--profile", "lan"};
    testbed.hosts[1].broker_options = {"--rank", "2", "--profile", "wifi"};
    expect_one("settings", "its brokers get `--profile wifi` and those of pi1 `--profile lan`");
    testbed.hosts[1].broker_options = {"--rank", "2", "--profile", "lan"};
    EXPECT_THAT(findings(), IsEmpty()) << "ranks may differ";
}

TEST_F(Ill, DoesNotHearAnother) {
    seen[1].heard.clear();
    expect_one("multicast", "does not hear the multicast of pi1 on `eth0`");
}

TEST_F(Ill, HearsShortDatagramsOnly) {
    seen[1].heard["pi1"] = 20;
    expect_one("mtu", "none of 1500 octets");
}

TEST_F(Ill, CannotMulticast) {
    seen[1].multicast_trouble = "No such device";
    expect_one("multicast", "cannot multicast on `eth0`: No such device");
}

TEST_F(Ill, IsNotReached) {
    seen[1] = HostSeen{};
    seen[1].trouble = "ssh cannot reach it (no route)";
    expect_one("reach", "no route");
}

TEST_F(Doctor, ItsFindingsAreJsonToo) {
    seen[1].facts->may_cut = false;
    const auto json = to_json(testbed, seen, findings());
    EXPECT_EQ(json["findings"][0]["host"], "pi2");
    EXPECT_EQ(json["findings"][0]["severity"], "warning");
    EXPECT_EQ(json["hosts"][0]["facts"]["mtu_octets"], 1500);
}

TEST(NetworkCut, LeavesSshAlone) {
    const SshPath ssh = parse_ssh_connection("10.60.0.4 41000 10.60.0.1 22");
    const std::string rules = cut_rules("eth0", ssh);
    EXPECT_THAT(rules, HasSubstr("ip daddr 10.60.0.1 tcp dport 22 accept"));
    EXPECT_THAT(rules, HasSubstr("arp daddr ip 10.60.0.1 accept"));
    EXPECT_THAT(rules, HasSubstr("policy drop"));
}

// It goes into a file of rules: nothing but addresses and ports may.
TEST(NetworkCut, TakesNothingButAddressesAndPorts) {
    for (const char* text : {"", "10.0.0.1", "10.0.0.1 41000 fd00::1 22", "a 1 b 2",
                             "10.0.0.1 1}accept 10.0.0.2 22", "10.0.0.1 999999 10.0.0.2 22"}) {
        EXPECT_THAT(parse_ssh_connection(text).client, IsEmpty()) << text;
    }
    EXPECT_THAT(cut_rules("eth0", {}), AllOf(Not(HasSubstr("accept")), HasSubstr("drop")));
}

}  // namespace
}  // namespace romano::experiments::doctor_test
