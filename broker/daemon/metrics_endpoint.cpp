#include "broker/daemon/metrics_endpoint.h"

#include <spdlog/spdlog.h>

#include <chrono>

#include "broker/daemon/refusal.h"
#include "broker/metrics/page.h"
#include "broker/metrics/process_metrics.h"
#include "broker/net/clock.h"
#include "broker/net/endpoint_text.h"

namespace romano::daemon {

MetricsEndpoint::MetricsEndpoint(boost::asio::io_context& io, const Settings& settings)
    : turns_(net::TurnClock::of(io)),
      name_(settings.name),
      start_(std::chrono::duration<double>(net::unix_time()).count()),
      server_(io, [this] { return page(); }) {
    if (!settings.metrics) return;
    if (const auto error = server_.open(*settings.metrics)) {
        throw Refusal("--metrics '" + net::to_text(*settings.metrics) + "': cannot be served (" +
                      error.message() + "); choose a free port of this machine");
    }
    spdlog::info("metrics: http://{}/metrics", net::to_text(server_.address()));
}

std::string MetricsEndpoint::page() {
    turns_.begin(net::now());
    metrics::Page page;
    metrics::add_process(page, name_, ROMANO_VERSION, start_);
    if (broker_ != nullptr) broker_->add_metrics(page);
    return page.text();
}

}  // namespace romano::daemon
