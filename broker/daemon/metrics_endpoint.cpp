#include "broker/daemon/metrics_endpoint.h"

#include <spdlog/spdlog.h>

#include <chrono>

#include "broker/daemon/http_settings.h"
#include "broker/daemon/refusal.h"
#include "broker/metrics/page.h"
#include "broker/metrics/process_metrics.h"
#include "broker/net/clock.h"
#include "broker/net/endpoint_text.h"

namespace romano::daemon {
namespace {

void add_refusals(metrics::Page& page, const https::Gate::Counts& counts) {
    const auto count = [&page](const char* reason, std::uint64_t value) {
        page.counter("romano_metrics_refusals_total",
                     "Who asked for this page and was refused, by reason", value,
                     {{"reason", reason}});
    };
    count("no_token", counts.without_token);
    count("wrong_token", counts.wrong_tokens);
    count("handshake", counts.handshakes_failed);
    count("crowded", counts.crowded);
}

}  // namespace

MetricsEndpoint::MetricsEndpoint(boost::asio::io_context& io, const Settings& settings)
    : turns_(net::TurnClock::of(io)),
      name_(settings.name),
      start_(std::chrono::duration<double>(net::unix_time()).count()),
      gate_(settings.metrics ? open_gate("metrics-token", settings.metrics->gate) : nullptr),
      server_(
          io, [this] { return page(); }, gate_) {
    if (!settings.metrics) return;
    if (const auto error = server_.open(settings.metrics->listen)) {
        refuse_option(
            "metrics", net::to_text(settings.metrics->listen),
            "cannot be served (" + error.message() + "); choose a free port of this machine");
    }
    spdlog::info("metrics: {}://{}/metrics", gate_ ? "https" : "http",
                 net::to_text(server_.address()));
}

std::string MetricsEndpoint::page() {
    turns_.begin(net::now());
    metrics::Page page;
    metrics::add_process(page, name_, ROMANO_VERSION, start_);
    if (gate_) add_refusals(page, gate_->counts());
    if (broker_ != nullptr) broker_->add_metrics(page);
    return page.text();
}

}  // namespace romano::daemon
