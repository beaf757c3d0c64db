#include "bench/scenarios.h"

namespace romano::bench {
namespace {

using namespace std::chrono_literals;
using experiments::LoadPlan;
using mqttsn::Qos;

}  // namespace

std::vector<Scenario> scenarios(Duration measured, bool small) {
    const auto plan = [&](std::uint32_t publishers, std::uint32_t subscribers, std::uint32_t topics,
                          Qos qos, std::uint32_t in_flight) {
        LoadPlan made;
        made.publishers = publishers;
        made.subscribers = subscribers;
        made.topics = topics;
        made.qos = qos;
        made.in_flight = in_flight;
        made.warm_up = measured / 4;
        made.duration = measured;
        return made;
    };
    const auto at_rate = [&](double rate) {
        LoadPlan made = plan(1, 1, 1, Qos::at_most_once, 1);
        made.rate_per_s = rate;
        return made;
    };
    const std::uint32_t many = small ? 100 : 10'000;
    // A key is made for each, and its files are written.
    const std::uint32_t fewer = small ? 50 : 1'000;
    // In a fan-out fewer messages are on their way, so that the datagrams are about as many.
    return {
        {"qos0_1_to_1", plan(1, 1, 1, Qos::at_most_once, 64), true},
        {"qos0_1_to_10", plan(1, 10, 1, Qos::at_most_once, 32), false},
        {"qos0_1_to_50", plan(1, 50, 1, Qos::at_most_once, 16), true},
        {"qos0_1_to_100", plan(1, 100, 1, Qos::at_most_once, 16), false},
        {.name = "cell_qos0_1_to_50",
         .plan = plan(1, 50, 1, Qos::at_most_once, 8),
         .is_for_cells = true},
        {"qos1_20_to_20", plan(20, 20, 20, Qos::at_least_once, 80), true},
        {"qos2_20_to_20", plan(20, 20, 20, Qos::exactly_once, 80), true},
        {"rate_1000_per_s", at_rate(1'000), true},
        {"rate_10000_per_s", at_rate(10'000), true},
        {"rate_50000_per_s", at_rate(50'000), false},
        {"sessions_10", plan(5, 5, 10, Qos::at_most_once, 60), false},
        {"sessions_many", plan(many / 2, many / 2, many, Qos::at_most_once, 60), false},
        {.name = "sessions_with_keys",
         .plan = plan(fewer / 2, fewer / 2, fewer, Qos::at_most_once, 60),
         .with_keys = true},
    };
}

}  // namespace romano::bench
