// romano-broker-uplink: a broker of a cluster that can hold the uplink. People start romano-broker.

#include <memory>
#include <utility>

#include "broker/daemon/program.h"
#include "broker/daemon/refusal.h"
#include "broker/uplink/mqtt/mqtt_link.h"
#include "overlay/daemon/cluster_broker.h"
#include "overlay/daemon/cluster_metrics.h"

namespace {

using namespace romano;

class Mqtt final : public daemon::Uplink {
public:
    Mqtt(boost::asio::io_context& io, const uplink::MqttSettings& settings,
         uplink::LinkEvents events)
        : link_(io, settings, std::move(events)) {}
    void carry_out(const uplink::UplinkAction& action) override { link_.carry_out(action); }
    void add_metrics(metrics::Page& page, const overlay::UplinkFacts& facts) const override {
        daemon::add_uplink(page, facts);
    }

private:
    uplink::MqttLink link_;
};

std::unique_ptr<daemon::Uplink> make_uplink(boost::asio::io_context& io,
                                            const uplink::MqttSettings& settings,
                                            uplink::LinkEvents events) {
    try {
        return std::make_unique<Mqtt>(io, settings, std::move(events));
    } catch (const std::runtime_error& error) {
        throw daemon::Refusal(error.what());
    }
}

}  // namespace

int main(int argc, char** argv) {
    using namespace romano::daemon;
    return run_program(
        argc, argv,
        {.prepare =
             [](const Settings& settings) {
                 if (!settings.uplink) throw Refusal("--uplink is missing; start romano-broker");
             },
         .start =
             [](boost::asio::io_context& io, const Settings& settings, OnServing on_serving) {
                 return std::make_unique<ClusterBroker>(io, settings, std::move(on_serving),
                                                        make_uplink);
             }});
}
