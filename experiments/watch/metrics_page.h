// A broker's page of metrics, read as numbers.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace romano::experiments {

using Labels = std::map<std::string, std::string>;

struct MetricSample {
    Labels labels;
    double value = 0;
};

class MetricsPage {
public:
    /// Lines that are no sample are passed over: pages of several versions may come.
    explicit MetricsPage(std::string_view text);

    /// All of that name; empty when there is none.
    [[nodiscard]] const std::vector<MetricSample>& all(const std::string& name) const;
    /// The only one, or the one with this label.
    [[nodiscard]] double value(const std::string& name, double otherwise = 0) const;
    [[nodiscard]] double value(const std::string& name, const std::string& label,
                               const std::string& is) const;
    [[nodiscard]] double sum(const std::string& name) const;
    [[nodiscard]] bool has(const std::string& name) const { return !all(name).empty(); }

private:
    std::map<std::string, std::vector<MetricSample>> samples_;
};

}  // namespace romano::experiments
