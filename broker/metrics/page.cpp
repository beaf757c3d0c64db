#include "broker/metrics/page.h"

#include <prometheus/metric_family.h>
#include <prometheus/text_serializer.h>

#include <chrono>
#include <sstream>

namespace romano::metrics {
namespace {

double seconds(Duration duration) {
    return std::chrono::duration<double>(duration).count();
}

prometheus::ClientMetric labelled(std::initializer_list<Label> labels) {
    prometheus::ClientMetric metric;
    for (const Label& label : labels) metric.label.push_back({label.name, label.value});
    return metric;
}

}  // namespace

class Page::Families {
public:
    /// The one of that name; metrics of a name come one after the other.
    prometheus::MetricFamily& at(std::string_view name, std::string_view help,
                                 prometheus::MetricType type) {
        if (list.empty() || list.back().name != name) {
            list.push_back({std::string{name}, std::string{help}, type, {}});
        }
        return list.back();
    }

    std::vector<prometheus::MetricFamily> list;
};

Page::Page() : families_(std::make_unique<Families>()) {}
Page::~Page() = default;

void Page::counter(std::string_view name, std::string_view help, std::uint64_t value,
                   std::initializer_list<Label> labels) {
    counter(name, help, static_cast<double>(value), labels);
}

void Page::counter(std::string_view name, std::string_view help, double value,
                   std::initializer_list<Label> labels) {
    auto metric = labelled(labels);
    metric.counter.value = value;
    families_->at(name, help, prometheus::MetricType::Counter).metric.push_back(std::move(metric));
}

void Page::gauge(std::string_view name, std::string_view help, double value,
                 std::initializer_list<Label> labels) {
    auto metric = labelled(labels);
    metric.gauge.value = value;
    families_->at(name, help, prometheus::MetricType::Gauge).metric.push_back(std::move(metric));
}

void Page::histogram(std::string_view name, std::string_view help,
                     const net::LatencyHistogram& histogram) {
    prometheus::ClientMetric metric;
    auto& out = metric.histogram;
    const auto& bounds = net::LatencyHistogram::bounds;
    for (std::size_t at = 0; at < bounds.size(); ++at) {
        out.sample_count += histogram.count(at);
        out.bucket.push_back({out.sample_count, seconds(bounds[at])});
    }
    out.sample_count += histogram.count(bounds.size());
    out.sample_sum = seconds(histogram.sum());
    families_->at(name, help, prometheus::MetricType::Histogram)
        .metric.push_back(std::move(metric));
}

std::string Page::text() const {
    std::ostringstream out;
    prometheus::TextSerializer{}.Serialize(out, families_->list);
    return out.str();
}

}  // namespace romano::metrics
