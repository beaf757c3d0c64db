#include "experiments/cli/loops.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "experiments/cli/report_run.h"
#include "experiments/loops/deviation.h"
#include "experiments/loops/formation.h"
#include "experiments/loops/margins.h"
#include "romano/cli/real_number.h"

namespace romano::experiments {
namespace {

constexpr const char* loops_examples = R"(Examples:
  romano loops                                   (all parts)
  romano loops --parts margins --periods 20,40 --losses 0,10 --poles 20
  romano loops --seed 7 --output results/loops7
  romano loops --parts deviation,formation --brokers 1,3 --runs 10
  romano loops --parts deviation --shove 0       (the wind alone)
  romano loops --parts deviation --worlds simulated,radio,processes --runs 10
Parts: margins (how much delay a pole bears that is balanced over the network: by theory, and found),
deviation (how far it leans when its broker fails), formation (five robots when their broker fails).
Worlds: simulated (the shipped cores of client, plant, controller and brokers, in virtual time), radio
(the same with the robots on modelled IEEE 802.15.4; needs ns-3), processes (romano-broker, and robots on
sockets, in real time: some 12 s a run, on a machine that has little else to do). In virtual time the same
seed gives the same numbers. Begun again, it goes on where it was interrupted. The folder then holds
report.html, each table as CSV, and each figure as SVG where gnuplot is.
)";

constexpr std::array all_worlds{LoopWorld::simulated, LoopWorld::radio, LoopWorld::processes};

struct LoopsOptions {
    ReportRun report{.parts = {"margins", "deviation", "formation"}, .output = "results/loops"};
    MarginsPlan margins;
    DeviationPlan deviation;
    FormationPlan formation;
    std::vector<std::string> worlds{std::string{name_of(LoopWorld::simulated)}};
    std::filesystem::path broker_program;
};

std::vector<LoopGround> grounds_of(const LoopsOptions& options) {
    std::vector<LoopGround> grounds;
    for (const LoopWorld world : all_worlds) {
        if (std::ranges::find(options.worlds, name_of(world)) == options.worlds.end()) continue;
        grounds.push_back({.world = world,
                           .broker_program = options.broker_program,
                           .traces = options.report.output / "traces"});
    }
    return grounds;
}

std::vector<SeparateRun> runs_of(const LoopsOptions& options) {
    std::vector<SeparateRun> all;
    const auto add = [&all](std::vector<SeparateRun> runs) {
        std::ranges::move(runs, std::back_inserter(all));
    };
    if (options.report.wants("margins")) add(runs_of(options.margins));
    for (const LoopGround& ground : grounds_of(options)) {
        if (options.report.wants("deviation")) add(runs_of(options.deviation, ground));
        if (options.report.wants("formation")) add(runs_of(options.formation, ground));
    }
    return all;
}

std::vector<Section> sections_of(const LoopsOptions& options, const std::filesystem::path& folder) {
    std::vector<Section> all;
    if (options.report.wants("margins")) all.push_back(margins_section(options.margins, folder));
    for (const LoopGround& ground : grounds_of(options)) {
        if (options.report.wants("deviation")) {
            all.push_back(deviation_section(options.deviation, ground.world, folder));
        }
        if (options.report.wants("formation")) {
            all.push_back(formation_section(options.formation, ground.world, folder));
        }
    }
    return all;
}

void run(const LoopsOptions& options) {
    if (const auto problem = problem_with(options.margins)) throw std::runtime_error(*problem);
    for (const LoopGround& ground : grounds_of(options)) {
        const std::string problem = problem_with(ground);
        if (!problem.empty()) throw std::runtime_error(problem);
    }
    run_to_report(
        options.report, runs_of(options),
        {"Control loops at work", "Control loops over the network"},
        [&](const std::filesystem::path& folder) { return sections_of(options, folder); });
}

}  // namespace

void add_loops(CLI::App& program, int& exit_code) {
    auto options = std::make_shared<LoopsOptions>();
    CLI::App& command = *program.add_subcommand(
        "loops", "Control loops at work: delay margins, and faults of brokers");
    command.set_help_flag("--help", "Show this and examples, and exit");
    add_report_options(command, options->report);
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
    command
        .add_option("--worlds", options->worlds,
                    "deviation, formation: simulated, radio, processes, or several")
        ->delimiter(',')
        ->check(CLI::IsMember({"simulated", "radio", "processes"}))
        ->capture_default_str();
    command.add_option(
        "--broker", options->broker_program,
        "processes: the broker's program (default: romano-broker beside this program)");
    command.footer(loops_examples);
    command.callback([options, &exit_code] {
        const std::uint64_t seed = options->report.seed;
        options->margins.seed = options->deviation.seed = options->formation.seed = seed;
        options->formation.brokers = options->deviation.brokers;
        options->formation.runs = options->deviation.runs;
        if (options->broker_program.empty()) {
            options->broker_program =
                std::filesystem::read_symlink("/proc/self/exe").parent_path() / "romano-broker";
        }
        run(*options);
        exit_code = 0;
    });
}

}  // namespace romano::experiments
