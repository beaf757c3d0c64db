// What a member of a cluster adds to the page of metrics.
#include "overlay/daemon/cluster_metrics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/broker/metrics/names.h"

namespace romano::daemon::cluster_metrics_test {
namespace {

using testing::HasSubstr;

TEST(ClusterMetrics, NamesFollowTheConventions) {
    overlay::MemberFacts facts;
    facts.peers.push_back({.name = "r2"});
    metrics::Page page;
    add_cluster(page, facts);
    add_uplink(page, {});
    metrics::expect_conventional_names(page.text());
}

TEST(ClusterMetrics, TellTheConditionInTheRank) {
    metrics::Page page;
    overlay::MemberFacts facts;
    facts.condition = 75;
    add_cluster(page, facts);
    EXPECT_THAT(page.text(), HasSubstr("\nromano_cluster_condition 75\n"));
}

TEST(ClusterMetrics, TellHowOftenTheLeaseWasLost) {
    metrics::Page page;
    overlay::MemberFacts facts;
    facts.leases_lost = 3;
    add_cluster(page, facts);
    EXPECT_THAT(page.text(), HasSubstr("\nromano_cluster_leases_lost_total 3\n"));
}

TEST(ClusterMetrics, TellWhatCameOfEachMessageOfTheUplink) {
    overlay::UplinkFacts facts{.is_up = true, .counters = {}, .too_long = 1};
    facts.counters = {.sent = 9,
                      .confirmed = 8,
                      .received = 20,
                      .busy = 7,
                      .duplicates = 6,
                      .own = 5,
                      .unwanted = 4,
                      .dropped = 3};
    metrics::Page page;
    add_uplink(page, facts);
    const std::string text = page.text();
    for (const char* line :
         {"is_up 1", "sent_total 9", "confirmed_total 8", "refused_total 7", "received_total 21",
          "drops_total{reason=\"duplicate\"} 6", "drops_total{reason=\"own\"} 5",
          "drops_total{reason=\"unwanted\"} 4", "drops_total{reason=\"link_down\"} 3",
          "drops_total{reason=\"too_long\"} 1"}) {
        EXPECT_THAT(text, HasSubstr("\nromano_uplink_" + std::string{line} + "\n"));
    }
}

}  // namespace
}  // namespace romano::daemon::cluster_metrics_test
