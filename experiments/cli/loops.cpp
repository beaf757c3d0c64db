#include "experiments/cli/loops.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include "experiments/cli/real_number.h"
#include "experiments/loops/deviation.h"
#include "experiments/loops/formation.h"
#include "experiments/loops/margins.h"
#include "experiments/process/separate_runs.h"
#include "experiments/report/section.h"
#include "experiments/sweep/progress_bar.h"

namespace romano::experiments {
namespace {

constexpr const char* loops_examples = R"(Examples:
  romano loops                                   (all parts)
  romano loops --parts margins --periods 20,40 --losses 0,10 --poles 20
  romano loops --seed 7 --output results/loops7
  romano loops --parts deviation,formation --brokers 1,3 --runs 10
  romano loops --parts deviation --shove 0       (the wind alone)
Parts: margins (how much delay a pole bears that is balanced over the network: by theory, and found),
deviation (how far it leans when its broker fails), formation (five robots when their broker fails).
The shipped cores of client, plant, controller and brokers, in virtual time (overlay/sim). The same seed
gives the same numbers. Begun again, it goes on where it was interrupted. The folder then holds
report.html, each table as CSV, and each figure as SVG where gnuplot is.
)";

struct LoopsOptions {
    std::vector<std::string> parts{"margins", "deviation", "formation"};
    MarginsPlan margins;
    DeviationPlan deviation;
    FormationPlan formation;
    std::uint64_t seed = 1;
    unsigned jobs = 2;
    bool fresh = false;
    std::filesystem::path output = "results/loops";

    [[nodiscard]] bool wants(const char* part) const {
        return std::ranges::find(parts, part) != parts.end();
    }
};

std::vector<SeparateRun> runs_of(const LoopsOptions& options) {
    std::vector<SeparateRun> all;
    const auto add = [&all](std::vector<SeparateRun> runs) {
        std::ranges::move(runs, std::back_inserter(all));
    };
    if (options.wants("margins")) add(runs_of(options.margins));
    if (options.wants("deviation")) add(runs_of(options.deviation));
    if (options.wants("formation")) add(runs_of(options.formation));
    return all;
}

std::vector<Section> sections_of(const LoopsOptions& options, const std::filesystem::path& folder) {
    std::vector<Section> all;
    if (options.wants("margins")) all.push_back(margins_section(options.margins, folder));
    if (options.wants("deviation")) all.push_back(deviation_section(options.deviation, folder));
    if (options.wants("formation")) all.push_back(formation_section(options.formation, folder));
    return all;
}

int run(const LoopsOptions& options) {
    if (const auto problem = problem_with(options.margins)) throw std::runtime_error(*problem);
    const auto folder = options.output / "runs";
    std::error_code failed;
    if (options.fresh) std::filesystem::remove_all(folder, failed);
    std::filesystem::create_directories(folder, failed);
    if (failed) {
        throw std::runtime_error("cannot write into --output `" + options.output.string() + "`");
    }
    const auto runs = runs_of(options);
    const auto done =
        std::ranges::count_if(runs, [&](const SeparateRun& one) { return is_done(one, folder); });
    ProgressBar bar{stderr, runs.size(), static_cast<std::size_t>(done)};
    bar.show(0, "begins");
    do_runs(runs, folder, options.jobs, [&](const SeparateRun& one) {
        bar.finish_quietly();
        bar.show(0, one.name);
    });
    bar.erase();
    const auto sections = sections_of(options, folder);
    write_report({"Control loops at work", "Control loops over the network, on the simulator"},
                 sections, options.output);
    std::printf("%s%s\n", to_text(sections).c_str(), (options.output / "report.html").c_str());
    return 0;
}

}  // namespace

void add_loops(CLI::App& program, int& exit_code) {
    auto options = std::make_shared<LoopsOptions>();
    CLI::App& command = *program.add_subcommand(
        "loops", "Control loops at work on the simulator: delay margins, and faults of brokers");
    command.set_help_flag("--help", "Show this and examples, and exit");
    command.add_option("--parts", options->parts, "Of the report, one or several")
        ->delimiter(',')
        ->check(CLI::IsMember(options->parts))
        ->capture_default_str();
    MarginsPlan& margins = options->margins;
    command.add_option("--periods", margins.periods_ms, "margins: of the loop, in ms")
        ->delimiter(',')
        ->check(CLI::Range(7, 1000))
        ->capture_default_str();
    command.add_option("--losses", margins.losses_percent, "margins: of rounds, in %")
        ->delimiter(',')
        ->check(real_number(0.0, 90.0))
        ->capture_default_str();
    command
        .add_option("--poles", margins.poles, "margins: that try each delay, where rounds are lost")
        ->check(CLI::Range(1, 1000))
        ->capture_default_str();
    command.add_option("--seconds", margins.seconds, "margins: that a pole has to stand")
        ->check(real_number(1.0, 1000.0))
        ->capture_default_str();
    command
        .add_option("--brokers", options->deviation.brokers,
                    "deviation, formation: counts of brokers, such as 1,3,5")
        ->delimiter(',')
        ->check(CLI::Range(1, 32))
        ->capture_default_str();
    command
        .add_option("--runs", options->deviation.runs,
                    "deviation, formation: with each count and fault")
        ->check(CLI::Range(1, 10'000))
        ->capture_default_str();
    command
        .add_option("--shove", options->deviation.shove_rad_s,
                    "deviation: how much faster the pole turns at the fault, rad/s")
        ->check(real_number(0.0, 2.0))
        ->capture_default_str();
    command.add_option("--seed", options->seed, "Of all runs")->capture_default_str();
    command.add_option("--jobs", options->jobs, "Runs at a time, a process each")
        ->check(CLI::Range(1, 256))
        ->capture_default_str();
    command.add_option("--output", options->output, "Folder of runs, tables, figures and report")
        ->capture_default_str();
    command.add_flag("--fresh", options->fresh,
                     "Forget the runs that stand in --output, as after a change of the code");
    command.footer(loops_examples);
    command.callback([options, &exit_code] {
        options->margins.seed = options->seed;
        options->deviation.seed = options->seed;
        options->formation.seed = options->seed;
        options->formation.brokers = options->deviation.brokers;
        options->formation.runs = options->deviation.runs;
        exit_code = run(*options);
    });
}

}  // namespace romano::experiments
