// --metrics: the page that Prometheus and `romano status` read.
#pragma once

#include <boost/asio/io_context.hpp>
#include <memory>
#include <string>

#include "broker/daemon/running_broker.h"
#include "broker/https/gate.h"
#include "broker/metrics/http_server.h"
#include "broker/net/turn_clock.h"

namespace romano::daemon {

class MetricsEndpoint {
public:
    /// Does nothing without the setting. Throws Refusal.
    MetricsEndpoint(boost::asio::io_context& io, const Settings& settings);
    /// From here on the page tells of this broker too, which lives as long as io runs.
    void tell_of(const RunningBroker& broker) { broker_ = &broker; }

private:
    [[nodiscard]] std::string page();

    net::TurnClock& turns_;
    std::string name_;
    double start_;
    std::shared_ptr<https::Gate> gate_;  // null: plain HTTP for whoever comes
    const RunningBroker* broker_ = nullptr;
    metrics::HttpServer server_;
};

}  // namespace romano::daemon
