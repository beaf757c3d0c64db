#include "experiments/cli/compare.h"

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include "experiments/compare/compare_report.h"
#include "experiments/sweep/results_folder.h"
#include "experiments/sweep/text_file.h"
#include "romano/cli/real_number.h"

namespace romano::experiments {
namespace {

constexpr const char* compare_examples = R"(Examples:
  romano compare results/before results/after
  romano compare results/before results/after --all --output results/compared
  romano compare results/demo results/demo-wifi --json | jq '.differences[] | select(.verdict == "worse")'
A and B are folders that `romano sweep` wrote. Configurations that both have are compared.
Exit code: 0; 2 when there is nothing to compare.
)";

constexpr std::size_t most_told_differences = 60;  // what somebody scrolls through

struct CompareOptions {
    std::filesystem::path a, b;
    std::filesystem::path output;
    double confidence_percent = 95;
    bool all = false;
    bool as_json = false;
};

void write_page(const Compared& compared, const std::filesystem::path& folder) {
    make_folder(folder);
    write_text(folder / "differences.csv", to_csv(compared));
    write_text(folder / "differences.json", to_json(compared));
    write_text(folder / "report.html", page_of(compared, folder / "plots"));
}

/// Numbers of another world are of another kind: the name says so.
std::string name_of(const std::filesystem::path& folder, const Results& results) {
    const World world = results.sweep.settings.world;
    return folder.string() +
           (world == World::processes ? "" : " (" + std::string{name_of(world)} + ")");
}

void compare_results(const CompareOptions& options) {
    const Results a = read_results(options.a);
    const Results b = read_results(options.b);
    Compared compared{.name_a = name_of(options.a, a),
                      .name_b = name_of(options.b, b),
                      .a = configurations_of(a.rows),
                      .b = configurations_of(b.rows),
                      .comparison = {},
                      .confidence = options.confidence_percent / 100};
    compared.comparison = compare(compared.a, compared.b, compared.confidence);
    if (compared.comparison.differences.empty()) {
        throw SweepError("`" + compared.name_a + "` and `" + compared.name_b +
                         "` have no configuration in common that was measured in both");
    }
    if (!options.output.empty()) write_page(compared, options.output);
    if (options.as_json) {
        std::fputs(to_json(compared).c_str(), stdout);
        return;
    }
    const SummaryTable table = table_of(compared, options.all);
    const SummaryTable told = options.all ? table : first_rows(table, most_told_differences);
    if (!told.rows.empty()) std::printf("%s\n", to_text(told).c_str());
    if (told.rows.size() < table.rows.size()) {
        std::printf("The first %zu of %zu differences; --all or --output has the others\n",
                    told.rows.size(), table.rows.size());
    }
    std::printf("%s\n", verdict_of(compared).c_str());
    if (!options.output.empty()) {
        std::printf("Report: %s\n",
                    std::filesystem::absolute(options.output / "report.html").c_str());
    }
}

}  // namespace

void add_compare(CLI::App& program, int& exit_code) {
    auto options = std::make_shared<CompareOptions>();
    CLI::App& command = *program.add_subcommand(
        "compare", "Set two sweeps' results beside each other: what differs, and how surely");
    command.add_option("A", options->a, "A results folder")->required();
    command.add_option("B", options->b, "Another one")->required();
    command.add_flag("--all", options->all, "List the figures without a difference, too");
    command
        .add_option("--confidence", options->confidence_percent,
                    "How surely an interval covers the true difference")
        ->type_name("PERCENT")
        ->check(real_number(50.0, 99.9))
        ->capture_default_str();
    command.add_option("--output", options->output,
                       "Write a page with the figures overlaid, CSV and JSON into this folder");
    command.add_flag("--json", options->as_json, "Print the comparison as JSON");
    command.footer(compare_examples);
    command.callback([options, &exit_code] {
        compare_results(*options);
        exit_code = 0;
    });
}

}  // namespace romano::experiments
