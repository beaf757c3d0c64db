// The folder a sweep writes: runs.csv, samples/, traces/, manifest.json, report.html. It is also
// the sweep's memory: rows that stand in runs.csv are done, and a sweep goes on behind them. Who
// has opened it has it alone.
//
// Each run's row is appended to runs.csv as it ends, whatever else there is. In the order of their
// cells, one row a cell, they stand once the folder is opened again or set_in_order() is called.
// Until then the last row of a cell counts.
#pragma once

#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "experiments/measure/delivery_account.h"
#include "experiments/sweep/claim.h"
#include "experiments/sweep/run_row.h"
#include "experiments/sweep/sweep_file.h"

namespace romano::experiments {

struct MemorySample {
    double at_s;  // since the load began
    std::string broker;
    double rss_mib;
};

class ResultsFolder {
public:
    /// Opens the folder, or makes it. With `fresh`, results of before are deleted. Throws
    /// SweepError when they are of another experiment, when another sweep has the folder open, or
    /// when it cannot be written.
    ResultsFolder(std::filesystem::path folder, const Sweep& sweep, bool fresh);

    [[nodiscard]] const std::filesystem::path& path() const { return folder_; }
    /// In the order of their cells.
    [[nodiscard]] std::vector<RunRow> rows() const;
    /// Null when it was not run yet.
    [[nodiscard]] const RunRow* row_of(const Cell& cell) const;

    /// In the place of an earlier row of that cell, if there is one.
    void put(const RunRow& row);
    void set_in_order();
    /// Takes these cells' rows, samples and traces over from another folder of the same experiment.
    void take(std::span<const RunRow> rows, const std::filesystem::path& from);
    /// Raw samples: one line a (message, receiver) pair.
    void write_samples(const Cell& cell, const DeliveryAccount& account) const;
    /// What the brokers' memory was at times within the load.
    void write_memory(const Cell& cell, const std::vector<MemorySample>& memory) const;
    /// Where a broker's trace of this cell goes.
    [[nodiscard]] std::filesystem::path trace_file(const Cell& cell, const std::string& name) const;

private:
    std::filesystem::path folder_;
    std::optional<Claim> claim_;
    std::map<Cell, RunRow> rows_;
    std::ofstream runs_;  // appends to runs.csv
};

/// What a folder holds, to be read only: a sweep may be going on in it.
struct Results {
    Sweep sweep;
    std::vector<RunRow> rows;
};
/// Throws SweepError when the folder holds no results of this version.
[[nodiscard]] Results read_results(const std::filesystem::path& folder);

/// "cell-0012": samples and traces of a cell are named so.
[[nodiscard]] std::string file_stem(const Cell& cell);

/// The samples as written, for figures that need every message.
struct Sample {
    RobotNumber publisher;
    std::uint32_t sequence;
    Stream stream;
    std::uint8_t qos;
    RobotNumber receiver;
    double sent_s;
    std::optional<double> delay_ms;
};
[[nodiscard]] std::vector<Sample> read_samples(const std::filesystem::path& folder,
                                               const Cell& cell);
[[nodiscard]] std::vector<MemorySample> read_memory(const std::filesystem::path& folder,
                                                    const Cell& cell);

}  // namespace romano::experiments
