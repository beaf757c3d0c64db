// The report: what all found, side by side, and in plain words who is better in what.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "bench/ros/figures.h"
#include "bench/ros/tasks.h"
#include "experiments/report/section.h"

namespace romano::bench::ros {

/// By a contestant's full name, and a task's name.
class Results {
public:
    void add(const std::string& contestant, const std::string& task, Figures figures) {
        all_[contestant][task] = std::move(figures);
    }
    [[nodiscard]] std::optional<double> get(const Contestant& contestant, const std::string& task,
                                            const std::string& figure) const;
    [[nodiscard]] const std::map<std::string, std::map<std::string, Figures>>& all() const {
        return all_;
    }

private:
    std::map<std::string, std::map<std::string, Figures>> all_;
};

[[nodiscard]] std::vector<experiments::Section> sections_of(const Plan& plan,
                                                            const Results& results);
/// One line a figure: contestant, task, figure, value.
[[nodiscard]] std::string to_csv(const Results& results);
[[nodiscard]] std::string to_json(const Results& results);

}  // namespace romano::bench::ros
