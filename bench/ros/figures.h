// What a run found: numbers by name, and the same as text, one a line.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace romano::bench::ros {

class Figures {
public:
    void set(const std::string& name, double value) { values_[name] = value; }
    void set(const std::string& name, std::optional<double> value) {
        if (value) values_[name] = *value;
    }
    [[nodiscard]] std::optional<double> get(const std::string& name) const {
        const auto found = values_.find(name);
        return found == values_.end() ? std::nullopt : std::optional{found->second};
    }
    [[nodiscard]] const std::map<std::string, double>& all() const { return values_; }

private:
    std::map<std::string, double> values_;
};

/// "name,value" lines under a head.
[[nodiscard]] std::string to_csv(const Figures& figures);
[[nodiscard]] Figures figures_in(std::string_view csv);

}  // namespace romano::bench::ros
