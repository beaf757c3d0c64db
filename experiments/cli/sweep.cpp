#include "experiments/cli/sweep.h"

#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "experiments/sweep/slurm.h"
#include "experiments/sweep/sweep_runner.h"

namespace romano::experiments {
namespace {

constexpr const char* sweep_examples = R"(Examples:
  romano sweep experiments/demo.toml               (goes on where it was interrupted)
  romano sweep experiments/demo.toml --fresh       (forgets earlier results)
  romano sweep experiments/demo.toml --list        (what it would run)
  romano sweep experiments/demo.toml --retry-failed  (runs that failed once more)
  romano sweep experiments/demo.toml --cell 7      (one cell again, in a folder of its own)
  romano sweep experiments/demo.toml --cell 7 --replace  (in the place of its earlier run)
  romano sweep experiments/demo.toml --shard 2/3   (every third cell, for the second of three machines)
  romano sweep experiments/demo.toml --slurm 8 --slurm-option=--partition=short   (as a job array)
  romano sweep experiments/demo.toml --hosts hosts.toml  (on machines of your own: romano testbed --help)
Sweeps may run side by side: each takes a loopback network and DDS domains that are free.
What a sweep file may say: experiments/README.md.
Exit code: 0; 1 when a run failed; 2 when nothing was run; 130 when interrupted.
)";

struct SweepOptions {
    SweepRequest request;
    std::uint32_t cell = 0;
    unsigned jobs = 1;
    std::string shard;
    std::string hosts;
    std::uint32_t slurm_shards = 0;
    std::vector<std::string> slurm_options;
    bool list = false;
};

Shard shard_in(const std::string& text) {
    const auto shard = parse_shard(text);
    if (!shard) throw SweepError("--shard `" + text + "`: must be I/N with I from 1 to N: 2/3");
    return *shard;
}

int submit_to_slurm(const SweepOptions& options) {
    namespace fs = std::filesystem;
    const Sweep sweep = read_sweep(options.request.file);
    if (options.slurm_shards > sweep.cells.size()) {
        throw SweepError("--slurm " + std::to_string(options.slurm_shards) +
                         ": the sweep has only " + std::to_string(sweep.cells.size()) + " cells");
    }
    const std::string said = submit({.program = fs::read_symlink("/proc/self/exe"),
                                     .file = fs::absolute(options.request.file),
                                     .output = fs::absolute(sweep.settings.output),
                                     .broker_program = options.request.broker_program,
                                     .shards = options.slurm_shards,
                                     .options = options.slurm_options});
    std::fputs(said.c_str(), stdout);
    return 0;
}

}  // namespace

void add_sweep(CLI::App& program, int& exit_code) {
    auto options = std::make_shared<SweepOptions>();
    CLI::App& command = *program.add_subcommand(
        "sweep", "Run an experiment: brokers, robots, faults, real or simulated; with a report");
    command.set_help_flag("--help", "Show this and examples, and exit");
    command.add_option("FILE", options->request.file, "The sweep file (TOML)")->required();
    CLI::Option* fresh =
        command.add_flag("--fresh", options->request.fresh, "Forget the results of before");
    CLI::Option* cell =
        command.add_option("--cell", options->cell, "Run this cell only")->excludes(fresh);
    command
        .add_flag("--replace", options->request.replace,
                  "Put the cell's new run into the results, in the place of the earlier one")
        ->needs(cell);
    command
        .add_flag("--retry-failed", options->request.retry_failed,
                  "Run the cells again whose runs failed, too")
        ->excludes(cell)
        ->excludes(fresh);
    CLI::Option* shard =
        command
            .add_option(
                "--shard", options->shard,
                "Run the I-th of N parts only, into OUTPUT-shards/I-of-N; then: romano merge")
            ->type_name("I/N")
            ->excludes(cell);
    CLI::Option* slurm =
        command
            .add_option("--slurm", options->slurm_shards,
                        "Submit the cells to Slurm as an array of N jobs, and one that merges them")
            ->type_name("N")
            ->check(CLI::Range(1U, most_shards))
            ->excludes(cell)
            ->excludes(fresh);
    command
        .add_option("--slurm-option", options->slurm_options,
                    "Of sbatch, for the array (repeatable): --slurm-option=--partition=short")
        ->type_name("OPTION")
        ->needs(slurm);
    CLI::Option* jobs = command
                            .add_option("--jobs", options->jobs,
                                        "Simulated cells at once (default: one for each core)")
                            ->type_name("N")
                            ->check(CLI::Range(1U, 1024U));
    command.add_flag("--list", options->list, "List the cells and run nothing");
    CLI::Option* hosts =
        command
            .add_option("--hosts", options->hosts,
                        "Run the brokers on the machines of this file, into OUTPUT-on-NAME; the "
                        "robots here")
            ->type_name("HOSTS")
            ->excludes(slurm)
            ->excludes(shard);
    command
        .add_option("--broker", options->request.broker_program,
                    "The broker's program (default: romano-broker beside this program)")
        ->excludes(hosts);
    command.footer(sweep_examples);
    command.callback([options, cell, jobs, &exit_code] {
        SweepRequest& request = options->request;
        if (options->list) {
            for (const Cell& each : read_sweep(request.file).cells) {
                std::printf("%4u  %s\n", each.number, describe(each).c_str());
            }
            exit_code = 0;
            return;
        }
        if (!options->shard.empty()) request.shard = shard_in(options->shard);
        if (cell->count() > 0) request.only_cell = options->cell;
        if (jobs->count() > 0) request.jobs = options->jobs;
        if (!options->hosts.empty()) request.hosts = options->hosts;
        if (request.broker_program.empty()) {
            request.broker_program =
                std::filesystem::read_symlink("/proc/self/exe").parent_path() / "romano-broker";
        }
        exit_code = options->slurm_shards > 0 ? submit_to_slurm(*options) : run_sweep(request);
    });
}

}  // namespace romano::experiments
