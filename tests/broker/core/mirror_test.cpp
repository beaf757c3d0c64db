// A mirror that applied a broker's log holds what the broker holds (design: replication).

#include "broker/core/mirror.h"

#include <gtest/gtest.h>

#include "tests/broker/core/random_clients.h"
#include "tests/broker/core/scripted_client.h"

namespace romano::broker::mirror_test {
namespace {

class RandomWorkload : public ::testing::TestWithParam<std::uint64_t> {};

TEST_P(RandomWorkload, LeavesMirrorAndHomeEqual) {
    SCOPED_TRACE("seed " + std::to_string(GetParam()));
    ScriptedBroker broker{logging_options()};
    RandomClients clients{broker, GetParam(), 8};
    for (int step = 0; step < 1500 && !::testing::Test::HasFailure(); ++step) {
        clients.step();
        if (step % 50 == 0) broker.expects_mirror_to_agree();
    }
    broker.expects_mirror_to_agree();
}

INSTANTIATE_TEST_SUITE_P(Seeds, RandomWorkload, ::testing::Range<std::uint64_t>(1, 13));

}  // namespace
}  // namespace romano::broker::mirror_test
