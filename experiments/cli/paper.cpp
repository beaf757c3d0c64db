#include "experiments/cli/paper.h"

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "experiments/cli/report_run.h"
#include "experiments/paper/backbone.h"
#include "experiments/paper/broadcast.h"
#include "experiments/paper/cells_plan.h"
#include "experiments/paper/energy.h"
#include "experiments/paper/moves.h"
#include "experiments/paper/paper_plan.h"
#include "experiments/paper/paper_report.h"
#include "romano/cli/real_number.h"

namespace romano::experiments {
namespace {

constexpr const char* paper_examples = R"(Examples:
  romano paper                                   (all parts)
  romano paper --parts table                     (ten rates, ten runs of 5,000 messages each)
  romano paper --parts table --runs 2 --messages 1000 --rates 180,200,220 --baud 230400 --seed 7
  romano paper --parts cells --brokers 1,2,4 --cell-channels 2
Parts: table (the paper's table and figure, each number it states beside ours), energy (what a message
costs, from the table's runs), cells (a broker for each cell), moves (failover and roaming), backbone
(brokers whose beacons are on the robots' channel), broadcast (one datagram for a whole cell).
The shipped cores on ns-3's IEEE 802.15.4 with 6LoWPAN, in virtual time (overlay/radio). The same seed
gives the same numbers. Begun again, it goes on where it was interrupted. The folder then holds
report.html, each table as CSV, and each figure as SVG where gnuplot is.
)";

struct Options {
    ReportRun report{.parts = {"table", "energy", "cells", "moves", "backbone", "broadcast"},
                     .output = "results/paper"};
    PaperPlan table;
    CellsPlan cells;
    MovesPlan moves;
    BackbonePlan backbone;
    BroadcastPlan broadcast;
};

std::vector<SeparateRun> runs_of(const Options& options) {
    std::vector<SeparateRun> all;
    const auto add = [&all](std::vector<SeparateRun> runs) {
        std::ranges::move(runs, std::back_inserter(all));
    };
    if (options.report.wants("table") || options.report.wants("energy"))
        add(runs_of(options.table));
    if (options.report.wants("cells")) add(runs_of(options.cells));
    if (options.report.wants("moves")) add(runs_of(options.moves));
    if (options.report.wants("backbone")) add(runs_of(options.backbone));
    if (options.report.wants("broadcast")) add(runs_of(options.broadcast));
    return all;
}

std::vector<Section> sections_of(const Options& options, const std::filesystem::path& folder) {
    std::vector<Section> all;
    if (options.report.wants("table"))
        all.push_back(paper_section(figures_of(options.table, folder)));
    if (options.report.wants("energy")) all.push_back(energy_section(options.table, folder));
    if (options.report.wants("cells")) all.push_back(cells_section(options.cells, folder));
    if (options.report.wants("moves")) all.push_back(moves_section(options.moves, folder));
    if (options.report.wants("backbone")) all.push_back(backbone_section(options.backbone, folder));
    if (options.report.wants("broadcast"))
        all.push_back(broadcast_section(options.broadcast, folder));
    return all;
}

void run(const Options& options) {
    if (const auto problem = problem_with(options.table)) throw std::runtime_error(*problem);
    run_to_report(
        options.report, runs_of(options),
        {"The ROMANO paper again",
         "The ROMANO paper's experiments on modelled IEEE 802.15.4 cells"},
        [&](const std::filesystem::path& folder) { return sections_of(options, folder); });
}

}  // namespace

void add_paper(CLI::App& program, int& exit_code) {
    auto options = std::make_shared<Options>();
    PaperPlan& plan = options->table;
    CLI::App& command = *program.add_subcommand(
        "paper", "The paper's experiments on modelled radio cells, and what many brokers change");
    command.set_help_flag("--help", "Show this and examples, and exit");
    add_report_options(command, options->report);
    command.add_option("--rates", plan.rates, "table: messages a second, such as 100,200,300")
        ->delimiter(',')
        ->check(real_number(0.1, 2000.0))
        ->capture_default_str();
    command
        .add_option("--baud", plan.router_bauds,
                    "table: of the border router's UART, one or several")
        ->delimiter(',')
        ->capture_default_str();
    command.add_option("--channel", plan.channel, "table: IEEE 802.15.4 channel, 11 to 26")
        ->capture_default_str();
    command.add_option("--runs", plan.runs, "table: at each rate; moves: of each kind")
        ->check(CLI::Range(1, 1000))
        ->capture_default_str();
    command
        .add_option("--messages", plan.messages, "table: of each run; for the delays 1000 at most")
        ->check(CLI::Range(1, 1'000'000))
        ->capture_default_str();
    command
        .add_option("--brokers", options->cells.brokers,
                    "cells: counts of brokers, such as 1,2,4; one cell each")
        ->delimiter(',')
        ->check(CLI::Range(1, 64))
        ->capture_default_str();
    command
        .add_option("--cell-channels", options->cells.channels,
                    "cells: channels that the cells take in turn")
        ->check(CLI::Range(1, 16))
        ->capture_default_str();
    command
        .add_option("--robots", options->broadcast.robots,
                    "broadcast: counts of robots in the cell, such as 1,10,50")
        ->delimiter(',')
        ->check(CLI::Range(1, 100))
        ->capture_default_str();
    command.footer(paper_examples);
    command.callback([options, &exit_code] {
        const std::uint64_t seed = options->report.seed;
        options->table.seed = options->cells.seed = seed;
        options->moves.seed = options->backbone.seed = options->broadcast.seed = seed;
        PaperPlan& table = options->table;
        options->moves.runs = table.runs;
        table.delay_messages = std::min(table.delay_messages, table.messages);
        run(*options);
        exit_code = 0;
    });
}

}  // namespace romano::experiments
