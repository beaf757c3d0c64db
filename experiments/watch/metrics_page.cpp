#include "experiments/watch/metrics_page.h"

#include <algorithm>
#include <charconv>
#include <utility>

namespace romano::experiments {
namespace {

/// `name="value",...}`: returns what follows the brace; empty when it is no list of labels.
std::optional<std::string_view> read_labels(std::string_view text, Labels& labels) {
    while (!text.empty() && text.front() != '}') {
        const auto equals = text.find("=\"");
        if (equals == std::string_view::npos) return std::nullopt;
        const std::string name{text.substr(0, equals)};
        text.remove_prefix(equals + 2);
        std::string value;
        while (!text.empty() && text.front() != '"') {
            if (text.front() == '\\' && text.size() > 1) {
                text.remove_prefix(1);
                value += text.front() == 'n' ? '\n' : text.front();
            } else {
                value += text.front();
            }
            text.remove_prefix(1);
        }
        if (text.empty()) return std::nullopt;
        text.remove_prefix(1);
        if (text.starts_with(',')) text.remove_prefix(1);
        labels.emplace(name, std::move(value));
    }
    if (text.empty()) return std::nullopt;
    return text.substr(1);
}

}  // namespace

MetricsPage::MetricsPage(std::string_view text) {
    while (!text.empty()) {
        const auto end = std::min(text.find('\n'), text.size());
        const std::string_view line = text.substr(0, end);
        text.remove_prefix(std::min(end + 1, text.size()));
        const auto name_end = line.find_first_of(" {");
        if (line.starts_with('#') || name_end == std::string_view::npos) continue;
        MetricSample sample;
        std::optional<std::string_view> rest = line.substr(name_end);
        if (line[name_end] == '{') rest = read_labels(line.substr(name_end + 1), sample.labels);
        if (!rest || !rest->starts_with(' ')) continue;
        const auto number = rest->substr(1);
        const auto [stop, error] =
            std::from_chars(number.data(), number.data() + number.size(), sample.value);
        if (error != std::errc{}) continue;
        samples_[std::string{line.substr(0, name_end)}].push_back(std::move(sample));
    }
}

const std::vector<MetricSample>& MetricsPage::all(const std::string& name) const {
    static const std::vector<MetricSample> none;
    const auto found = samples_.find(name);
    return found == samples_.end() ? none : found->second;
}

double MetricsPage::value(const std::string& name, double otherwise) const {
    const auto& samples = all(name);
    return samples.empty() ? otherwise : samples.front().value;
}

double MetricsPage::value(const std::string& name, const std::string& label,
                          const std::string& is) const {
    for (const MetricSample& sample : all(name)) {
        const auto found = sample.labels.find(label);
        if (found != sample.labels.end() && found->second == is) return sample.value;
    }
    return 0;
}

double MetricsPage::sum(const std::string& name) const {
    double total = 0;
    for (const MetricSample& sample : all(name)) total += sample.value;
    return total;
}

}  // namespace romano::experiments
