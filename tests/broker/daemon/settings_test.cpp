#include "broker/daemon/settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "broker/daemon/broker_options.h"
#include "broker/daemon/refusal.h"
#include "broker/daemon/web_page.h"
#include "broker/net/endpoint_text.h"
#include "tests/temporary_folder.h"

namespace romano::daemon::settings_test {
namespace {

using namespace std::chrono_literals;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

std::string refusal(const SettingTexts& texts) {
    try {
        (void)check(texts);
    } catch (const Refusal& refused) {
        return refused.what();
    }
    return "accepted";
}

/// The sentence names the option and the value, and says more.
auto names(const char* option, const char* value) {
    return AllOf(StartsWith("--" + std::string(option) + " '" + value + "': "),
                 testing::SizeIs(testing::Gt(20U)));
}

TEST(Settings, AloneForThisMachineWithoutAnySetting) {
    const Settings settings = check({});
    ASSERT_EQ(settings.listen.size(), 1U);
    EXPECT_EQ(net::to_text(settings.listen.front()), "127.0.0.1:1883");
    EXPECT_FALSE(settings.cluster);
    EXPECT_FALSE(settings.name.empty());
    EXPECT_TRUE(settings.discovery_groups.empty());
    EXPECT_EQ(settings.gateway_id, 1);
}

TEST(Settings, AdvertiseComesEveryQuarterOfAnHourUnlessGivenAndOnlyInDiscoveryGroups) {
    EXPECT_EQ(check({}).advertise_period, 0s);
    const std::vector<std::string> groups{"225.1.1.1:1883"};
    EXPECT_EQ(check({.discovery_group = groups}).advertise_period, 900s);
    const SettingTexts given{.advertise_period = "65535", .discovery_group = groups};
    EXPECT_EQ(check(given).advertise_period, 65'535s);
    EXPECT_EQ(broker_options(check(given)).advertise_every, 65'535s);
    for (const char* wrong : {"0", "65536", "often"}) {
        EXPECT_THAT(refusal({.advertise_period = wrong, .discovery_group = groups}),
                    names("advertise-period", wrong));
    }
    EXPECT_THAT(refusal({.advertise_period = "60"}),
                AllOf(names("advertise-period", "60"), HasSubstr("--discovery-group")));
}

TEST(Settings, EveryLimitReachesTheCoreAndHasARange) {
    for (const LimitSetting& setting : limit_settings()) {
        SettingTexts texts;
        texts.limits[setting.key] = std::to_string(setting.low);
        EXPECT_EQ(check(texts).limits.*setting.limit, setting.low) << setting.key;
        for (const std::string& wrong : {std::to_string(setting.high + 1), std::string("-1"),
                                         std::string("many"), std::string()}) {
            texts.limits[setting.key] = wrong;
            EXPECT_THAT(refusal(texts), names(setting.key, wrong.c_str()));
        }
        EXPECT_GE(broker::Limits{}.*setting.limit, setting.low);
        EXPECT_LE(broker::Limits{}.*setting.limit, setting.high);
    }
}

TEST(Settings, ThePageIsForThisMachineUnlessItIsToldOtherwise) {
    EXPECT_FALSE(check({}).web);
    EXPECT_EQ(net::to_text(check({.web = "127.0.0.1:8080"}).web->listen), "127.0.0.1:8080");
    EXPECT_EQ(net::to_text(check({.web = "[::1]:8080"}).web->listen), "[::1]:8080");
    for (const char* wrong : {"", "8080", "localhost:8080", "127.0.0.1", "225.1.1.1:8080"}) {
        EXPECT_THAT(refusal({.web = wrong}), names("web", wrong));
    }
    EXPECT_THAT(refusal({.web = "0.0.0.0:8080"}),
                AllOf(names("web", "0.0.0.0:8080"), HasSubstr("can steer all robots"),
                      HasSubstr("--let-everybody-steer")));
    EXPECT_TRUE(check({.web = "0.0.0.0:8080", .let_everybody_steer = true}).web);
    EXPECT_THAT(refusal({.let_everybody_steer = true}), HasSubstr("--web"));
}

TEST(Settings, MetricsAreForThisMachineUnlessTheyHaveATokenOrMayBePlain) {
    EXPECT_FALSE(check({}).metrics);
    EXPECT_FALSE(check({.metrics = "127.0.0.1:9883"}).metrics->gate);
    EXPECT_FALSE(check({.metrics = "[::1]:9883"}).metrics->gate);
    for (const char* beyond : {"0.0.0.0:9883", "[::]:9883", "192.0.2.1:9883"}) {
        EXPECT_THAT(refusal({.metrics = beyond}),
                    AllOf(names("metrics", beyond), HasSubstr("--metrics-token FILE"),
                          HasSubstr("--allow-plain")));
        EXPECT_FALSE(check({.allow_plain = true, .metrics = beyond}).metrics->gate);
        const Settings guarded =
            check({.metrics = beyond, .metrics_token = "t", .http_certificate = "https.pem"});
        EXPECT_EQ(guarded.metrics->gate->certificate, "https.pem");
        EXPECT_EQ(guarded.metrics->gate->token, "t");
    }
    EXPECT_THAT(refusal({.metrics = "225.1.1.1:9883"}), names("metrics", "225.1.1.1:9883"));
    EXPECT_THAT(refusal({.metrics_token = "t", .http_certificate = "https.pem"}),
                AllOf(names("metrics-token", "t"), HasSubstr("--metrics ADDR:PORT")));
    EXPECT_THAT(refusal({.metrics = "127.0.0.1:9883", .metrics_token = "t"}),
                AllOf(names("metrics-token", "t"), HasSubstr("--http-certificate FILE")));
    EXPECT_THAT(refusal({.metrics = "127.0.0.1:9883", .http_certificate = "https.pem"}),
                AllOf(names("http-certificate", "https.pem"), HasSubstr("--metrics-token")));
}

TEST(Settings, ATokenIsShownToTheCertificateInTheFolderOfKeysUnlessAnotherIsGiven) {
    const tests::TemporaryFolder folder;
    SettingTexts texts{.listen = {"protected://127.0.0.1:1885"},
                       .keys = folder.path().string(),
                       .metrics = "0.0.0.0:9883",
                       .metrics_token = "t"};
    EXPECT_THAT(refusal(texts), HasSubstr("--keys DIR with a broker.pem"));
    std::ofstream(folder / "broker.pem") << "PEM";
    EXPECT_EQ(check(texts).metrics->gate->certificate, folder / "broker.pem");
    texts.http_certificate = "https.pem";
    EXPECT_EQ(check(texts).metrics->gate->certificate, "https.pem");
}

TEST(Settings, ThePageHasATokenOfItsOwn) {
    const SettingTexts texts{
        .web = "0.0.0.0:8080", .web_token = "t", .http_certificate = "https.pem"};
    const Settings guarded = check(texts);
    EXPECT_EQ(guarded.web->gate->token, "t");
    EXPECT_THAT(web_arguments(*guarded.web, guarded.listen),
                testing::ElementsAre("web", "-h", "127.0.0.1", "-p", "1883", "--listen",
                                     "0.0.0.0:8080", "--certificate", "https.pem", "--token", "t"));
    SettingTexts both = texts;
    both.let_everybody_steer = true;
    EXPECT_THAT(refusal(both), AllOf(names("web-token", "t"), HasSubstr("exclude each other")));
    EXPECT_THAT(refusal({.web_token = "t", .http_certificate = "https.pem"}),
                AllOf(names("web-token", "t"), HasSubstr("--web ADDR:PORT")));
    EXPECT_THAT(refusal({.web = "0.0.0.0:8080", .web_token = "t"}),
                AllOf(names("web-token", "t"), HasSubstr("--http-certificate FILE")));
}

TEST(Settings, ThePageOfABrokerForClientsWithKeysNeedsOne) {
    const std::vector<std::string> sealed{"protected://127.0.0.1:1885"};
    const std::vector<std::string> both{"127.0.0.1:1883", sealed.front()};
    const SettingTexts without{.listen = sealed, .keys = "k", .web = "127.0.0.1:8080"};
    EXPECT_THAT(refusal(without), AllOf(names("web", "127.0.0.1:8080"), HasSubstr("--web-key")));
    SettingTexts with = without;
    with.web_key = "anna.key";
    EXPECT_EQ(check(with).web->key_file, "anna.key");
    EXPECT_FALSE(check({.listen = both, .keys = "k", .web = "127.0.0.1:8080"}).web->key_file);
    EXPECT_THAT(refusal({.web = "127.0.0.1:8080", .web_key = "anna.key"}),
                AllOf(names("web-key", "anna.key"), HasSubstr("protected://")));
    EXPECT_THAT(refusal({.listen = sealed, .keys = "k", .web_key = "anna.key"}),
                AllOf(names("web-key", "anna.key"), HasSubstr("--web ADDR:PORT")));
}

TEST(WebPage, SpeaksToItsBrokerWhereThisMachineReachesIt) {
    const auto arguments = [](std::vector<std::string> listen, std::optional<std::string> key) {
        const Settings settings = check({.listen = std::move(listen),
                                         .allow_plain = true,
                                         .keys = key ? std::optional<std::string>("k") : key,
                                         .web = "127.0.0.1:8080",
                                         .web_key = key});
        return web_arguments(*settings.web, settings.listen);
    };
    using testing::ElementsAre;
    EXPECT_THAT(arguments({"0.0.0.0:1883"}, {}),
                ElementsAre("web", "-h", "127.0.0.1", "-p", "1883", "--listen", "127.0.0.1:8080"));
    EXPECT_THAT(arguments({"[::]:7"}, {}),
                ElementsAre("web", "-h", "::1", "-p", "7", "--listen", "127.0.0.1:8080"));
    EXPECT_THAT(arguments({"192.0.2.1:1883", "protected://192.0.2.1:1885"}, "anna.key"),
                ElementsAre("web", "-h", "192.0.2.1", "-p", "1885", "--key", "anna.key", "--listen",
                            "127.0.0.1:8080"));
}

TEST(Settings, AStoreIsForABrokerAlone) {
    const Settings settings = check({.store = "/tmp/s.db", .store_limit_mb = "3"});
    ASSERT_TRUE(settings.store);
    EXPECT_EQ(settings.store->path, "/tmp/s.db");
    EXPECT_EQ(settings.store->most_octets, 3U << 20U);
    EXPECT_THAT(refusal({.domain = "7", .store = "/tmp/s.db"}), names("store", "/tmp/s.db"));
    EXPECT_THAT(refusal({.store = ""}), names("store", ""));
    EXPECT_THAT(refusal({.store_limit_mb = "5"}), names("store-limit-mb", "5"));
    EXPECT_THAT(refusal({.store = "/tmp/s.db", .store_limit_mb = "0"}),
                names("store-limit-mb", "0"));
    EXPECT_THAT(refusal({.store_sync = true}), HasSubstr("--store-sync"));
}

TEST(Settings, TheDefaultNameDiffersBetweenBrokersOfOneHost) {
    EXPECT_NE(check({.listen = {"127.0.0.1:1883"}}).name,
              check({.listen = {"127.0.0.2:1883"}}).name);
}

TEST(Settings, ADomainMakesAMember) {
    const Settings settings = check({.domain = "7",
                                     .interface = "lo",
                                     .rank = "3",
                                     .acks = "2",
                                     .beacon_ms = "20",
                                     .detection_timeout_ms = "150"});
    ASSERT_TRUE(settings.cluster);
    EXPECT_EQ(settings.cluster->domain, 7U);
    EXPECT_EQ(settings.cluster->interface, "lo");
    EXPECT_EQ(settings.cluster->rank, 3U);
    EXPECT_EQ(settings.cluster->acks, 2U);
    EXPECT_EQ(settings.cluster->beacon_every, 20ms);
    EXPECT_EQ(settings.cluster->detection_timeout, 150ms);
}

TEST(Settings, AProfileSetsTheTimesTogether) {
    const Settings lan = check({.domain = "7"});
    const Settings mesh = check({.domain = "7", .profile = "mesh"});
    EXPECT_EQ(lan.cluster->beacon_every, 10ms);
    EXPECT_EQ(mesh.cluster->beacon_every, 1s);
    EXPECT_GT(mesh.cluster->detection_timeout, lan.cluster->detection_timeout);
    EXPECT_GT(mesh.cluster->phi_threshold, lan.cluster->phi_threshold);
    EXPECT_GT(mesh.t_retry, lan.t_retry);
}

TEST(Settings, EachTimeOfAProfileMayBeGiven) {
    const Settings settings = check({.domain = "7",
                                     .profile = "wifi",
                                     .beacon_ms = "20",
                                     .detection_timeout_ms = "80",
                                     .phi_threshold = "5",
                                     .retry_ms = "700",
                                     .retries = "3"});
    EXPECT_EQ(settings.cluster->beacon_every, 20ms);
    EXPECT_EQ(settings.cluster->detection_timeout, 80ms);
    EXPECT_EQ(settings.cluster->phi_threshold, 5);
    EXPECT_EQ(settings.t_retry, 700ms);
    EXPECT_EQ(settings.n_retry, 3);
}

TEST(Settings, BeaconsMustBeShorterThanHalfTheTimeout) {
    EXPECT_THAT(refusal({.beacon_ms = "40"}), names("beacon-ms", "40"));
    EXPECT_THAT(refusal({.beacon_ms = "40", .detection_timeout_ms = "79"}),
                names("detection-timeout-ms", "79"));
}

TEST(Settings, RaftNeedsVotersAndOthersNeedNone) {
    const Settings settings = check({.domain = "7", .elector = "raft", .voters = {"r1,r2", "r3"}});
    EXPECT_THAT(settings.cluster->voters, testing::ElementsAre("r1", "r2", "r3"));
    EXPECT_THAT(refusal({.elector = "raft"}), AllOf(names("elector", "raft"), HasSubstr("voters")));
    EXPECT_THAT(refusal({.voters = {"r1"}}), names("voters", "r1"));
    EXPECT_THAT(refusal({.elector = "raft", .voters = {"r1", "r1"}}), names("voters", "r1"));
    EXPECT_THAT(refusal({.elector = "raft", .voters = {"r1,r2", "r1"}}), names("voters", "r1"));
    EXPECT_THAT(refusal({.elector = "raft", .voters = {"a/b"}}), names("voters", "a/b"));
    EXPECT_THAT(refusal({.elector = "raft", .voters = {"r1,,r2"}}), names("voters", ""));
    EXPECT_THAT(refusal({.name = "r1,r2"}), names("name", "r1,r2"));
}

TEST(Settings, AllPeersMayBeAskedToHoldAnEvent) {
    EXPECT_EQ(check({.domain = "7", .condition_file = "battery"}).cluster->condition_file,
              "battery");
    EXPECT_EQ(check({.domain = "7", .acks = "all"}).cluster->acks, std::nullopt);
}

TEST(Settings, PredefinedTopicsMayHoldEqualsSigns) {
    const auto topics = check({.predefined = {"1=a", "65534=b=c"}}).predefined_topics;
    EXPECT_EQ(topics.at(mqttsn::TopicId{1}), "a");
    EXPECT_EQ(topics.at(mqttsn::TopicId{65534}), "b=c");
}

TEST(Settings, TheDefaultDiscoveryGroupsFollowTheFamiliesServed) {
    const auto groups = [](std::vector<std::string> listen) {
        return check({.listen = std::move(listen), .discovery_group = {"default"}})
            .discovery_groups.size();
    };
    EXPECT_EQ(groups({"127.0.0.1:1883"}), 1U);
    EXPECT_EQ(groups({"[::1]:1883"}), 1U);
    EXPECT_EQ(groups({"127.0.0.1:1883", "[::1]:1883"}), 2U);
}

TEST(Settings, RefusesWhatIsNoAddressToListenOn) {
    EXPECT_THAT(refusal({.listen = {"127.0.0.1"}}), names("listen", "127.0.0.1"));
    EXPECT_THAT(refusal({.listen = {"localhost:1883"}}), names("listen", "localhost:1883"));
    EXPECT_THAT(refusal({.listen = {"225.1.1.1:1883"}}), names("listen", "225.1.1.1:1883"));
    EXPECT_THAT(refusal({.listen = {"127.0.0.1:1", "127.0.0.1:1"}}),
                names("listen", "127.0.0.1:1"));
}

TEST(Settings, PlainAddressesThatOthersReachNeedThePlainWordsForIt) {
    for (const char* address :
         {"192.168.1.5:1883", "0.0.0.0:1883", "[::]:1883", "[fd00::5]:1883"}) {
        EXPECT_THAT(refusal({.listen = {address}}),
                    AllOf(names("listen", address), HasSubstr("--allow-plain")));
        EXPECT_EQ(check({.listen = {address}, .allow_plain = true}).listen.size(), 1U);
    }
    EXPECT_EQ(check({.listen = {"127.7.7.7:1", "[::1]:1"}}).listen.size(), 2U);
    EXPECT_EQ(check({.listen = {"protected://192.168.1.5:1"}, .keys = "b1"}).listen.size(), 1U);
    EXPECT_EQ(net::to_text(check({.allow_plain = true}).listen.front()), "0.0.0.0:1883");
}

TEST(Settings, AProtectedAddressNeedsKeysAndAPortOfItsOwn) {
    const std::string sealed = "protected://127.0.0.1:1885";
    const Settings settings = check({.listen = {sealed, "127.0.0.1:1883"}, .keys = "fleet/b1"});
    EXPECT_EQ(settings.listen[0].packets, Endpoint::Packets::sealed);
    EXPECT_EQ(settings.listen[1].packets, Endpoint::Packets::plain);
    EXPECT_EQ(net::to_text(settings.listen[0]), sealed);
    EXPECT_EQ(settings.name.find('/'), std::string::npos) << settings.name;
    EXPECT_THAT(refusal({.listen = {sealed}}), names("listen", sealed.c_str()));
    EXPECT_THAT(refusal({.keys = "fleet/b1"}), names("keys", "fleet/b1"));
    EXPECT_TRUE(check({.keys = "fleet/b1", .domain = "7"}).keys) << "it may stand in for others";
    EXPECT_THAT(refusal({.listen = {sealed, "127.0.0.1:1885"}, .keys = "fleet/b1"}),
                names("listen", "127.0.0.1:1885"));
    EXPECT_THAT(refusal({.listen = {"dtls://127.0.0.1:1885"}}),
                names("listen", "dtls://127.0.0.1:1885"));
}

TEST(Settings, RefusesANameThatCannotStandInATopic) {
    for (const char* name : {"", "a/b", "a+", "#", "a b", "\xff"}) {
        EXPECT_THAT(refusal({.name = name}), names("name", name));
    }
    EXPECT_NE(refusal({.name = std::string(65, 'x')}), "accepted");
}

TEST(Settings, RefusesADomainThatDdsDoesNotHave) {
    for (const char* domain : {"231", "-1", "seven", "", "99999999999999999999"}) {
        EXPECT_THAT(refusal({.domain = domain}), names("domain", domain));
    }
}

TEST(Settings, RefusesAnUnknownInterfaceAndListsThoseThatAreThere) {
    EXPECT_THAT(refusal({.domain = "7", .interface = "no-such"}),
                AllOf(names("interface", "no-such"), HasSubstr("lo")));
}

TEST(Settings, RefusesWhatABrokerAloneCannotDo) {
    const auto wants_a_domain = [](const char* option, const char* value) {
        return AllOf(names(option, value), HasSubstr("--domain"));
    };
    EXPECT_THAT(refusal({.interface = "lo"}), wants_a_domain("interface", "lo"));
    EXPECT_THAT(refusal({.rank = "3"}), wants_a_domain("rank", "3"));
    EXPECT_THAT(refusal({.acks = "2"}), wants_a_domain("acks", "2"));
    EXPECT_THAT(refusal({.acks = "all"}), wants_a_domain("acks", "all"));
    EXPECT_THAT(refusal({.elector = "bully"}), wants_a_domain("elector", "bully"));
    EXPECT_THAT(refusal({.detector = "fixed"}), wants_a_domain("detector", "fixed"));
}

TEST(Settings, ALinkLocalAddressNeedsItsInterface) {
    EXPECT_THAT(refusal({.listen = {"[fe80::1]:1883"}, .allow_plain = true}),
                AllOf(names("listen", "[fe80::1]:1883"), HasSubstr("%eth0")));
    EXPECT_EQ(refusal({.listen = {"[fe80::1%lo]:1883"}, .allow_plain = true}), "accepted");
}

TEST(Settings, ADefaultThatIsWrittenOutIsNoReasonToRefuse) {
    EXPECT_EQ(refusal({.rank = "0", .acks = "1", .elector = "component", .detector = "link"}),
              "accepted");
}

TEST(Settings, RefusesUnknownAlgorithmsAndListsThoseThatAreThere) {
    EXPECT_THAT(refusal({.elector = "dice"}),
                AllOf(names("elector", "dice"), HasSubstr("component")));
    EXPECT_THAT(refusal({.detector = "oracle"}),
                AllOf(names("detector", "oracle"), HasSubstr("fixed")));
    EXPECT_THAT(refusal({.profile = "satellite"}),
                AllOf(names("profile", "satellite"), HasSubstr("wifi")));
    EXPECT_THAT(refusal({.log_level = "loud"}),
                AllOf(names("log-level", "loud"), HasSubstr("info")));
}

TEST(Settings, RefusesNumbersOutOfRange) {
    EXPECT_THAT(refusal({.rank = "high"}), names("rank", "high"));
    EXPECT_THAT(refusal({.acks = "most"}), names("acks", "most"));
    EXPECT_THAT(refusal({.beacon_ms = "0"}), names("beacon-ms", "0"));
    EXPECT_THAT(refusal({.detection_timeout_ms = "19"}), names("detection-timeout-ms", "19"));
    EXPECT_THAT(refusal({.phi_threshold = "0"}), names("phi-threshold", "0"));
    EXPECT_THAT(refusal({.retry_ms = "9"}), names("retry-ms", "9"));
    EXPECT_THAT(refusal({.retries = "many"}), names("retries", "many"));
    EXPECT_THAT(refusal({.gateway_id = "0"}), names("gateway-id", "0"));
    EXPECT_THAT(refusal({.gateway_id = "256"}), names("gateway-id", "256"));
}

TEST(Settings, RefusesBadPredefinedTopics) {
    for (const char* text : {"1", "=a", "0=a", "65535=a", "x=a", "1=", "1=a/+", "1=#"}) {
        EXPECT_THAT(refusal({.predefined = {text}}), names("predefined", text));
    }
    EXPECT_THAT(refusal({.predefined = {"1=a", "1=b"}}), names("predefined", "1=b"));
}

TEST(Settings, RefusesADiscoveryGroupThatIsNone) {
    EXPECT_THAT(refusal({.discovery_group = {"127.0.0.1:1883"}}),
                names("discovery-group", "127.0.0.1:1883"));
    EXPECT_THAT(refusal({.listen = {"127.0.0.1:1883"}, .discovery_group = {"[ff02::1]:1883"}}),
                names("discovery-group", "[ff02::1]:1883"));
}

TEST(Settings, ACellGroupIsAMulticastGroupOfAPlainAddressAndNotThatOfDiscovery) {
    EXPECT_FALSE(check({}).cell_group);
    EXPECT_TRUE(check({.listen = {"127.0.0.1:1883"}, .cell_group = "239.1.2.3:1884"}).cell_group);
    for (const char* wrong : {"127.0.0.1:1884", "239.1.2.3:0", "239.1.2.3", "cell", "",
                              "[ff05::1]:1884", "[ff02::1]:1884"}) {
        EXPECT_THAT(refusal({.listen = {"127.0.0.1:1883"}, .cell_group = wrong}),
                    names("cell-group", wrong));
    }
    EXPECT_THAT(refusal({.listen = {"127.0.0.1:1883"},
                         .discovery_group = {"225.1.1.1:1883"},
                         .cell_group = "225.1.1.1:1883"}),
                names("cell-group", "225.1.1.1:1883"));
    EXPECT_THAT(refusal({.listen = {"protected://127.0.0.1:1883"},
                         .keys = "/",
                         .cell_group = "239.1.2.3:1884"}),
                names("cell-group", "239.1.2.3:1884"));
}

}  // namespace
}  // namespace romano::daemon::settings_test
