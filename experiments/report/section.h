// A part of the report of an experiment: words, tables and a figure.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "experiments/report/plot.h"
#include "experiments/report/summary_table.h"

namespace romano::experiments {

struct SectionTable {
    std::string name;  // of its file, without .csv
    SummaryTable table;
    bool is_only_csv = false;  // too long to be read
};

struct Section {
    std::string title;
    std::string words;
    std::vector<SectionTable> tables;
    Plot figure;
};

[[nodiscard]] std::string to_text(const std::vector<Section>& sections);
struct ReportHead {
    std::string title;    // of the window
    std::string heading;  // of the page
};

/// Each table as CSV, each figure as SVG (where gnuplot is), and report.html with all of them.
void write_report(const ReportHead& head, const std::vector<Section>& sections,
                  const std::filesystem::path& folder);

}  // namespace romano::experiments
