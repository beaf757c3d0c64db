#include "overlay/sim/lone_world.h"

#include <chrono>

#include "overlay/sim/seed.h"

namespace romano::sim {

using namespace std::chrono_literals;

broker::BrokerOptions LoneWorld::quick_broker() {
    broker::BrokerOptions options;
    options.log = {broker::broker_id_of("alone"), 1};
    options.t_retry = 500ms;
    options.n_retry = 20;  // bad links must not make it drop a message
    options.t_wait = 1s;
    return options;
}

LoneWorld::LoneWorld(std::uint64_t seed, broker::BrokerOptions options)
    : World(seed),
      broker_({.name = "alone",
               .node = broker_node(0),
               .addresses = {service_address(0)},
               .broker = std::move(options)},
              events(), clients(), trace(), seed_of(seed, "broker")) {
    broker_.start();
}

}  // namespace romano::sim
