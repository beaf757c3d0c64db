// One page of metrics in Prometheus's text format, put together from plain numbers at the moment
// somebody asks. prometheus-cpp writes the format.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "broker/net/latency_histogram.h"

namespace romano::metrics {

struct Label {
    std::string name;
    std::string value;
};

class Page {
public:
    Page();
    ~Page();

    /// What only grows; the name ends in _total. Repeated with other labels for one name.
    void counter(std::string_view name, std::string_view help, std::uint64_t value,
                 std::initializer_list<Label> labels = {});
    void counter(std::string_view name, std::string_view help, double value,
                 std::initializer_list<Label> labels = {});
    /// What rises and falls.
    void gauge(std::string_view name, std::string_view help, double value,
               std::initializer_list<Label> labels = {});
    void histogram(std::string_view name, std::string_view help,
                   const net::LatencyHistogram& histogram);

    [[nodiscard]] std::string text() const;

private:
    class Families;
    std::unique_ptr<Families> families_;
};

}  // namespace romano::metrics
