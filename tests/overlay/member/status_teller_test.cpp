// What members tell people of brokers, and how soon.

#include "overlay/member/status_teller.h"

#include <gmock/gmock.h>

#include <chrono>

#include "overlay/member/status_topic.h"
#include "tests/overlay/member/steps.h"

namespace romano::test::status_teller_test {
namespace {

using namespace std::chrono_literals;
using mqttsn::Qos;
using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;

/// The heir takes the address after the view in which the dead one is no member, and its beacons
/// tell others of it: that is news at once, and not when the next second is over.
TEST(StatusTeller, TellsAtOnceWhoServesADeadBrokersAddress) {
    Brokers brokers;
    start(brokers, {1, 2, 3});
    const Robot& person =
        subscriber(brokers, "person", 3, Qos::at_most_once, overlay::status_topic("b1"));
    brokers.run_for(1s);
    brokers.kill(2);
    brokers.run_for(200ms);
    ASSERT_EQ(brokers.server_of(2), 1) << "3 has the person";
    EXPECT_THAT(person.received(),
                Contains(AllOf(HasSubstr('"' + overlay::to_text(broker_address(1)) + '"'),
                               HasSubstr('"' + overlay::to_text(broker_address(2)) + '"'))));
}

}  // namespace
}  // namespace romano::test::status_teller_test
