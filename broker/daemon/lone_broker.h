// A broker without a cluster: the broker core on sockets and one timer. Writes a log only for its
// store; says about itself under $SYS/brokers/ what a member says about all brokers.
#pragma once

#include <boost/asio/io_context.hpp>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "broker/core/broker_core.h"
#include "broker/daemon/bad_senders.h"
#include "broker/daemon/heap_limit.h"
#include "broker/daemon/persistence.h"
#include "broker/daemon/processor_load.h"
#include "broker/daemon/protection.h"
#include "broker/daemon/rights_in_force.h"
#include "broker/daemon/running_broker.h"
#include "broker/net/core_timer.h"
#include "broker/net/udp_service.h"
#include "broker/server/carried_server.h"

namespace romano::daemon {

class LoneBroker final : public RunningBroker, private net::DatagramHandler {
public:
    /// Throws Refusal.
    LoneBroker(boost::asio::io_context& io, const Settings& settings, const OnServing& on_serving);
    void leave() override;
    void read_rights_again() override;
    void add_metrics(metrics::Page& page) const override;

private:
    void on_datagram(const Endpoint& via, const Endpoint& from, Bytes octets) override;
    void on_message(const Endpoint& via, const Endpoint& from, Bytes message);
    void on_batch_end() override;
    void on_core_wakeup();
    void on_status_wakeup();
    [[nodiscard]] broker::BrokerOptions options_of(const Settings& settings);
    void obey_rights();
    void publish_status();
    void send();

    boost::asio::io_context& io_;
    std::string name_;
    std::unique_ptr<Protection> protection_;  // null without --keys
    RightsInForce rights_;
    std::optional<Persistence> persistence_;
    broker::BrokerOptions options_;
    broker::BrokerCore core_;
    broker::CarriedServer server_;
    broker::Actions actions_;
    net::UdpService udp_;
    net::CoreTimer core_timer_;
    net::CoreTimer status_timer_;
    std::string last_status_;
    ProcessorLoad processor_load_;
    BadSenders bad_senders_;
    HeapLimit heap_limit_;
};

}  // namespace romano::daemon
