// romano-broker-member: a broker of a cluster, over Cyclone DDS. People start romano-broker.

#include <memory>
#include <utility>

#include "broker/daemon/program.h"
#include "broker/daemon/refusal.h"
#include "overlay/daemon/cluster_broker.h"

int main(int argc, char** argv) {
    using namespace romano::daemon;
    return run_program(
        argc, argv,
        {.prepare =
             [](const Settings& settings) {
                 if (!settings.cluster) {
                     throw Refusal("--domain is missing; start romano-broker for a broker alone");
                 }
             },
         .start =
             [](boost::asio::io_context& io, const Settings& settings, OnServing on_serving) {
                 return std::make_unique<ClusterBroker>(io, settings, std::move(on_serving));
             }});
}
