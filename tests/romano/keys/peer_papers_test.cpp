// What brokers know each other by, as OpenSSL judges it; DDS itself judges it in
// tests/system/protected_peers_test.cpp.

#include "romano/keys/peer_papers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "romano/keys/key_error.h"
#include "romano/keys/key_folder.h"
#include "romano/keys/private_file.h"
#include "tests/temporary_folder.h"

namespace romano::keys::peer_papers_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

struct PeerPapers : testing::Test {
    PeerPapers() { fleet.add({.brokers = {"b1", "b2"}, .robots = {}, .operators = {}}); }
    [[nodiscard]] std::string of(const std::string& broker, const char* file) const {
        return read_private_file(fleet.broker_folder(broker) / file);
    }

    tests::TemporaryFolder folder;
    KeyFolder fleet{folder.path()};
};

TEST_F(PeerPapers, OfANewBrokerAreComplete) {
    EXPECT_TRUE(has_peer_papers(fleet.broker_folder("b1")));
    EXPECT_THAT(problems_of_peer_papers(fleet.broker_folder("b1")), IsEmpty());
    EXPECT_THAT(problems_of(folder.path()), IsEmpty());
    EXPECT_THAT(of("b1", permissions_name),
                HasSubstr("<subject_name>CN=b1,O=ROMANO brokers</subject_name>"));
}

TEST_F(PeerPapers, OfABrokerThatHasSomeStay) {
    const std::string before = of("b1", broker_certificate_name);
    fleet.add({.brokers = {"b1", "b3"}, .robots = {}, .operators = {}});
    EXPECT_EQ(of("b1", broker_certificate_name), before);
    EXPECT_TRUE(has_peer_papers(fleet.broker_folder("b3")));
}

TEST_F(PeerPapers, ARevokedCertificateIsOnEveryBrokersListAndANewOneIsNot) {
    const std::string stolen = of("b2", broker_certificate_name);
    fleet.withdraw({}, {"b2"});
    EXPECT_FALSE(std::filesystem::exists(fleet.broker_folder("b2")));
    EXPECT_TRUE(is_revoked(stolen, of("b1", revoked_name)));
    EXPECT_FALSE(is_revoked(of("b1", broker_certificate_name), of("b1", revoked_name)));
    fleet.add({.brokers = {"b2"}, .robots = {}, .operators = {}});
    EXPECT_FALSE(is_revoked(of("b2", broker_certificate_name), of("b2", revoked_name)));
    fleet.withdraw({}, {"b1"});
    EXPECT_TRUE(is_revoked(stolen, of("b2", revoked_name))) << "for ever";
    write_private_file(fleet.broker_folder("b2") / broker_certificate_name, stolen);
    EXPECT_THAT(problems_of_peer_papers(fleet.broker_folder("b2")),
                ElementsAre(HasSubstr("broker.pem: is revoked")));
    EXPECT_THROW(fleet.withdraw({}, {"b9"}), KeyError);
}

TEST_F(PeerPapers, ARenewedCertificateIsAnotherAndTheEarlierOneStillCounts) {
    const std::string before = of("b1", broker_certificate_name);
    fleet.renew("b1", 30);
    EXPECT_NE(of("b1", broker_certificate_name), before);
    EXPECT_FALSE(is_revoked(before, of("b2", revoked_name)));
    EXPECT_THROW(fleet.renew("b9", 30), KeyError);
    EXPECT_THROW(fleet.renew("../b1", 30), KeyError);
}

TEST_F(PeerPapers, FlawsAreSaid) {
    const auto own = fleet.broker_folder("b1");
    const auto problem = [&] { return problems_of_peer_papers(own); };
    write_private_file(own / broker_certificate_name,
                       Authority(folder.path()).issue("b1", Holder::broker, -1));
    EXPECT_THAT(problem(), ElementsAre(HasSubstr("has expired")));
    tests::TemporaryFolder elsewhere;
    write_private_file(own / broker_certificate_name,
                       Authority(elsewhere.path()).issue("b1", Holder::broker, 1));
    EXPECT_THAT(problem(), ElementsAre(HasSubstr("is of another authority")));
    std::filesystem::remove(own / revoked_name);
    EXPECT_THAT(problem(), ElementsAre(HasSubstr("revoked.pem: is missing")));
    EXPECT_THAT(problems_of(folder.path()), ElementsAre(HasSubstr("revoked.pem: is missing")));
}

}  // namespace
}  // namespace romano::keys::peer_papers_test
