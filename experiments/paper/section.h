// A part of the report of `romano paper`: words, tables and a figure.
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
};

struct Section {
    std::string title;
    std::string words;
    std::vector<SectionTable> tables;
    Plot figure;
};

[[nodiscard]] std::string to_text(const std::vector<Section>& sections);
/// Each table as CSV, each figure as SVG (where gnuplot is), and report.html with all of them.
void write_report(const std::vector<Section>& sections, const std::filesystem::path& folder);

}  // namespace romano::experiments
