// The results folder of a run: raw trials as CSV, one row each as soon as it is done, so that an
// interrupted run goes on; summary as JSON, figure as SVG.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "bench/failover/options.h"
#include "bench/failover/trial.h"
#include "bench/failover/watched.h"

namespace romano::bench {

class Results {
public:
    /// Reads the trials that are there already, unless `options.fresh`. Throws std::runtime_error
    /// when they are of other settings.
    explicit Results(const Options& options);

    [[nodiscard]] const std::vector<Trial>& trials() const { return trials_; }
    [[nodiscard]] std::filesystem::path traces() const { return options_.output / "traces"; }
    void add(const Trial& trial);
    void add(const Watched& watched) { watched_ = watched; }
    /// Writes summary.json and failover.svg, and a table to stdout.
    void conclude() const;

private:
    Options options_;
    std::filesystem::path file_;
    std::vector<Trial> trials_;
    std::optional<Watched> watched_;
};

}  // namespace romano::bench
