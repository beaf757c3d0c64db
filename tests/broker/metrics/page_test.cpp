// Names and numbers as Prometheus's text format wants them.

#include "broker/metrics/page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "broker/metrics/broker_metrics.h"
#include "broker/metrics/process_metrics.h"
#include "tests/broker/metrics/names.h"

namespace romano::metrics::page_test {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

std::string whole_page() {
    broker::Counters counters;
    counters.received_by_type[0x0C] = 5;
    counters.dropped[static_cast<std::size_t>(broker::Drop::queue_full)] = 7;
    broker::Census census;
    census.sessions[static_cast<std::size_t>(broker::SessionState::asleep)] = 3;
    net::NetCounters datagrams;
    datagrams.handling.add(60us, 2);
    datagrams.handling.add(3ms, 1);
    datagrams.handling.add(5s, 1);
    Page page;
    add_process(page, "r1", "1.2.3", 1e9);
    add_messages(page, counters);
    add_census(page, census);
    add_datagrams(page, datagrams);
    return page.text();
}

TEST(Page, GivesCountersAndGaugesWithTheirLabels) {
    const std::string page = whole_page();
    EXPECT_THAT(page, HasSubstr("romano_messages_received_total{type=\"PUBLISH\"} 5\n"));
    EXPECT_THAT(page, HasSubstr("romano_drops_total{reason=\"queue_full\"} 7\n"));
    EXPECT_THAT(page, HasSubstr("romano_sessions{state=\"asleep\"} 3\n"));
    EXPECT_THAT(page, HasSubstr("romano_broker_info{name=\"r1\",version=\"1.2.3\"} 1\n"));
    EXPECT_THAT(page, HasSubstr("# TYPE romano_messages_received_total counter\n"));
}

TEST(Page, GivesHistogramsCumulatively) {
    const std::string page = whole_page();
    EXPECT_THAT(page, HasSubstr("romano_datagram_handling_seconds_bucket{le=\"5e-05\"} 0\n"));
    EXPECT_THAT(page, HasSubstr("romano_datagram_handling_seconds_bucket{le=\"0.0001\"} 2\n"));
    EXPECT_THAT(page, HasSubstr("romano_datagram_handling_seconds_bucket{le=\"0.005\"} 3\n"));
    EXPECT_THAT(page, HasSubstr("romano_datagram_handling_seconds_bucket{le=\"+Inf\"} 4\n"));
    EXPECT_THAT(page, HasSubstr("romano_datagram_handling_seconds_count 4\n"));
}

TEST(Page, NamesFollowTheConventions) {
    expect_conventional_names(whole_page());
}

TEST(Page, AHostileNameStaysWithinItsLabel) {
    Page page;
    page.gauge("romano_test", "A test.", 1, {{"name", "a\"} 1\nromano_forged 1"}});
    EXPECT_THAT(page.text(), testing::Not(HasSubstr("\nromano_forged")));
}

}  // namespace
}  // namespace romano::metrics::page_test
