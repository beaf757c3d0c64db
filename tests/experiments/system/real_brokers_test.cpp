// Loops over brokers that are processes, in real time: what befalls them befalls the loop.
//
// How long anything takes is bounded only so that no busy machine breaks it; `romano loops --worlds
// processes` measures.
#include "experiments/loops/real_brokers.h"

#include <gtest/gtest.h>

#include "experiments/loops/deviation.h"
#include "tests/temporary_folder.h"

namespace romano::experiments::real_brokers_test {
namespace {

DeviationRun on_processes(std::size_t brokers, BrokerFault fault) {
    const tests::TemporaryFolder folder;
    return deviate({}, {.ground = {.world = LoopWorld::processes,
                                   .broker_program = BROKER_PROGRAM,
                                   .traces = folder / "traces"},
                        .brokers = brokers,
                        .fault = fault,
                        .seed = 5});
}

TEST(LoopOnProcesses, FallsBackOnceWhileItsOnlyBrokerIsSilentAndGoesOnWithIt) {
    const DeviationRun run = on_processes(1, BrokerFault::silence);
    EXPECT_FALSE(run.angle_deg) << "no pole stands for a second without a command";
    EXPECT_GE(run.falls_back, 1U);
    ASSERT_TRUE(run.wait_ms);
    EXPECT_GE(*run.wait_ms, 900);
}

TEST(LoopOnProcesses, GoesOnWithTheOtherBrokersWhenItsOwnIsKilledOrLeft) {
    for (const BrokerFault fault : {BrokerFault::crash_for_good, BrokerFault::roaming}) {
        const DeviationRun run = on_processes(3, fault);
        ASSERT_TRUE(run.wait_ms) << name_of(fault);
        // Robots that have to connect again need 15 s and more: who only listens notices late.
        EXPECT_LT(*run.wait_ms, 10'000) << name_of(fault);
    }
}

}  // namespace
}  // namespace romano::experiments::real_brokers_test
