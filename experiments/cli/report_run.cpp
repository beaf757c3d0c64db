#include "experiments/cli/report_run.h"

#include <algorithm>
#include <cstdio>
#include <stdexcept>
#include <system_error>

#include "experiments/sweep/progress_bar.h"

namespace romano::experiments {

bool ReportRun::wants(const char* part) const {
    return std::ranges::find(parts, part) != parts.end();
}

void add_report_options(CLI::App& command, ReportRun& run) {
    command.add_option("--parts", run.parts, "Of the report, one or several")
        ->delimiter(',')
        ->check(CLI::IsMember(run.parts))
        ->capture_default_str();
    command.add_option("--seed", run.seed, "Of all runs")->capture_default_str();
    command.add_option("--jobs", run.jobs, "Runs at a time, a process each")
        ->check(CLI::Range(1, 256))
        ->capture_default_str();
    command.add_option("--output", run.output, "Folder of runs, tables, figures and report")
        ->capture_default_str();
    command.add_flag("--fresh", run.fresh,
                     "Forget the runs that stand in --output, as after a change of the code");
}

void run_to_report(const ReportRun& run, const std::vector<SeparateRun>& runs,
                   const ReportHead& head, const SectionsOf& sections_of) {
    const auto folder = run.output / "runs";
    std::error_code failed;
    if (run.fresh) std::filesystem::remove_all(folder, failed);
    std::filesystem::create_directories(folder, failed);
    if (failed) {
        throw std::runtime_error("cannot write into --output `" + run.output.string() + "`");
    }
    const auto done =
        std::ranges::count_if(runs, [&](const SeparateRun& one) { return is_done(one, folder); });
    ProgressBar bar{stderr, runs.size(), static_cast<std::size_t>(done)};
    bar.show(0, "begins");
    do_runs(runs, folder, run.jobs, [&](const SeparateRun& one) {
        bar.finish_quietly();
        bar.show(0, one.name);
    });
    bar.erase();
    const auto sections = sections_of(folder);
    write_report(head, sections, run.output);
    std::printf("%s%s\n", to_text(sections).c_str(), (run.output / "report.html").c_str());
}

}  // namespace romano::experiments
