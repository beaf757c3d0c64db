#include "experiments/sweep/sweep_runner.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <functional>
#include <iterator>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "experiments/process/program.h"
#include "experiments/report/summary_table.h"
#include "experiments/sweep/air_world.h"
#include "experiments/sweep/cell_processes.h"
#include "experiments/sweep/cell_run.h"
#include "experiments/sweep/manifest.h"
#include "experiments/sweep/place.h"
#include "experiments/sweep/process_world.h"
#include "experiments/sweep/progress_bar.h"
#include "experiments/sweep/radio_world.h"
#include "experiments/sweep/results_folder.h"
#include "experiments/sweep/simulated_world.h"
#include "experiments/sweep/telling.h"
#include "experiments/sweep/text_file.h"
#include "experiments/testbed/testbed_world.h"

namespace romano::experiments {
namespace {

volatile std::sig_atomic_t interrupted = 0;

/// Ctrl-C and SIGTERM end the sweep between two moments of a cell, so that its brokers are stopped.
void listen_for_interrupts() {
    struct sigaction action = {};
    action.sa_handler = [](int) { interrupted = 1; };
    ::sigaction(SIGINT, &action, nullptr);
    ::sigaction(SIGTERM, &action, nullptr);
}

std::string utc_now_for_people() {
    const std::time_t now = std::time(nullptr);
    std::tm utc{};
    ::gmtime_r(&now, &utc);
    std::array<char, 32> text{};
    std::strftime(text.data(), text.size(), "%Y-%m-%d %H:%M:%S UTC", &utc);
    return text.data();
}

/// What `romano-broker --version` says, in one line.
std::string version_of(const std::filesystem::path& program) {
    const ProgramEnd end = run_program(program.string(), {"--version"});
    return end.ok() ? end.output.substr(0, end.output.find('\n')) : "unknown";
}

std::string line_of(const RunRow& row) {
    std::string line = "cell " + std::to_string(row.cell.number) + ": " + describe(row.cell);
    if (!row.ok()) return line + ": FAILED: " + row.status;
    line += ": delivered " +
            number_text(row.delivery_ratio ? Measured{*row.delivery_ratio * 100} : Measured{}, 2) +
            " %, p99 " + number_text(row.delay_p99_ms, 1) + " ms";
    if (row.failover_probe_ms) {
        line += ", failover " + number_text(row.failover_probe_ms, 0) + " ms (probe)";
    } else if (row.failover_clients) {
        line += ", robots hear again after " + number_text(row.failover_first_ms, 0) + ".." +
                number_text(row.failover_last_ms, 0) + " ms";
    }
    const std::string broken = row.broken_promises();
    return broken.empty() ? line : line + ": BROKEN: " + broken;
}

const Cell& cell_numbered(const Sweep& sweep, std::uint32_t number) {
    if (number == 0 || number > sweep.cells.size()) {
        throw SweepError("--cell " + std::to_string(number) + ": the sweep has cells 1 to " +
                         std::to_string(sweep.cells.size()));
    }
    return sweep.cells[number - 1];
}

/// In order. Of one shard, if one is asked for.
std::vector<Cell> cells_in_question(const Sweep& sweep, const SweepRequest& request) {
    if (request.only_cell) return {cell_numbered(sweep, *request.only_cell)};
    std::vector<Cell> cells = sweep.cells;
    if (!request.shard) return cells;
    const Shard& shard = *request.shard;
    if (shard.of > cells.size()) {
        throw SweepError("--shard " + text_of(shard) + ": the sweep has only " +
                         std::to_string(cells.size()) + " cells");
    }
    std::erase_if(
        cells, [&](const Cell& cell) { return (cell.number - 1) % shard.of != shard.number - 1; });
    return cells;
}

/// The cells that a merged result of earlier shards has already; they may have been others.
std::set<Cell> done_elsewhere(const Sweep& sweep, const SweepRequest& request) {
    std::set<Cell> done;
    if (!request.shard || !std::filesystem::exists(sweep.settings.output / "runs.csv")) return done;
    const Results whole = read_results(sweep.settings.output);
    if (!is_same_experiment(whole.sweep, sweep)) return done;
    for (const RunRow& row : whole.rows) {
        if (row.ok()) done.insert(row.cell);
    }
    return done;
}

bool is_to_run(const Cell& cell, const SweepRequest& request, const ResultsFolder& results,
               const std::set<Cell>& done) {
    if (request.only_cell) return true;
    if (done.contains(cell)) return false;
    const RunRow* row = results.row_of(cell);
    return row == nullptr || (request.retry_failed && !row->ok());
}

/// Parts have results of their own: machines that share a folder run side by side.
std::filesystem::path output_of(const Sweep& sweep, const SweepRequest& request) {
    std::filesystem::path output = sweep.settings.output;
    if (request.hosts) output = output_on(output, *request.hosts);
    if (request.only_cell && !request.replace) {
        return output / ("cell-" + std::to_string(*request.only_cell) + "-again");
    }
    if (!request.shard) return output;
    output += "-shards";
    return output /
           (std::to_string(request.shard->number) + "-of-" + std::to_string(request.shard->of));
}

void check_program(const std::filesystem::path& program) {
    if (::access(program.c_str(), X_OK) == 0) return;
    throw SweepError("no broker to run: `" + program.string() +
                     "` is no program; build romano-broker, or name it with --broker");
}

void tell_about_hosts(const std::string& what) {
    std::fprintf(stderr, "%s\n", what.c_str());
}

NetworkPlace claim_network_of(const SweepSettings& settings) {
    if (auto place = claim_network(settings.network)) return std::move(*place);
    if (settings.network.empty()) throw SweepError("no loopback network is free; set `network`");
    throw SweepError("`network = \"" + settings.network +
                     "\"`: another sweep is using it; leave it out, and a free one is taken");
}

using MakeWorld = std::function<std::unique_ptr<CellWorld>(const Cell& cell)>;

/// Real cells one after the other: they share processors. False when interrupted.
bool run_in_turn(const Sweep& sweep, const std::vector<Cell>& cells, const MakeWorld& make_world,
                 ResultsFolder& results, ProgressBar& bar) {
    for (const Cell& cell : cells) {
        const CellSurroundings surroundings{
            .make_world = make_world,
            .results = results,
            .on_progress =
                [&bar, &cell](double share, std::string_view doing) {
                    bar.show(share, describe(cell) + ": " + std::string{doing});
                },
            .is_interrupted = [] { return interrupted != 0; }};
        try {
            const RunRow row = CellRun{sweep.settings, cell, surroundings}.run();
            results.put(row);
            bar.finish_cell(line_of(row));
        } catch (const Interrupted&) {
            return false;
        }
    }
    return true;
}

/// Simulated cells on all cores. False when interrupted.
bool run_at_once(const Sweep& sweep, const std::vector<Cell>& cells, const MakeWorld& make_world,
                 unsigned at_once, ResultsFolder& results, ProgressBar& bar) {
    const CellProcesses processes{
        .at_once = at_once,
        .run =
            [&](const Cell& cell, const CellProcesses::Tell& tell) {
                const CellSurroundings surroundings{
                    .make_world = make_world,
                    .results = results,
                    .on_progress = tell,
                    .is_interrupted = [] { return interrupted != 0; }};
                return CellRun{sweep.settings, cell, surroundings}.run();
            },
        .on_row =
            [&](const RunRow& row) {
                results.put(row);
                bar.finish_cell(line_of(row));
            },
        .on_progress = [&](double share, std::string_view doing) { bar.show(share, doing); },
        .is_interrupted = [] { return interrupted != 0; }};
    return processes.run_all(cells);
}

}  // namespace

int run_sweep(const SweepRequest& request) {
    Sweep sweep = read_sweep(request.file);
    const std::vector<Cell> cells = cells_in_question(sweep, request);
    const std::set<Cell> done = done_elsewhere(sweep, request);
    if (request.only_cell && !request.replace) sweep.cells = cells;
    sweep.settings.output = output_of(sweep, request);
    const bool is_simulated = is_in_virtual_time(sweep.settings.world);
    if (request.jobs && !is_simulated) {
        throw SweepError(
            "--jobs " + std::to_string(*request.jobs) +
            ": only cells of a simulated or a radio world run at once; real ones would take "
            "each other's processor");
    }
    std::optional<NetworkPlace> network;
    std::optional<TestbedPlace> testbed;
    MakeWorld make_world;
    std::string broker_version;
    if (is_simulated) {
        if (request.hosts) {
            throw SweepError("--hosts: the sweep file says `world = \"" +
                             std::string{name_of(sweep.settings.world)} +
                             "\"`, which needs no hosts; leave one of them out");
        }
        check_simulated_broker_options(sweep.settings);
        if (sweep.settings.world == World::radio) check_radio(sweep.settings, sweep.cells);
        make_world = [&](const Cell& cell) -> std::unique_ptr<CellWorld> {
            if (sweep.settings.world == World::radio) return make_radio_world(sweep.settings, cell);
            return std::make_unique<SimulatedWorld>(sweep.settings, cell);
        };
    } else if (request.hosts && sweep.settings.world == World::air) {
        throw SweepError(
            "--hosts: the sweep file says `world = \"air\"`, whose channel is on this machine; "
            "leave "
            "one of them out");
    } else if (request.hosts) {
        testbed.emplace(*request.hosts, sweep.settings, cells, tell_about_hosts);
        broker_version = testbed->broker_version();
        make_world = [&](const Cell& cell) {
            return std::make_unique<TestbedWorld>(sweep.settings, cell, *testbed);
        };
    } else {
        const bool is_on_air = sweep.settings.world == World::air;
        if (is_on_air) check_air(sweep.settings, sweep.cells);
        check_program(request.broker_program);
        network = claim_network_of(sweep.settings);
        broker_version = version_of(request.broker_program);
        make_world = [&, is_on_air](const Cell& cell) -> std::unique_ptr<CellWorld> {
            if (is_on_air) {
                return make_air_world(sweep.settings, cell, network->network,
                                      request.broker_program);
            }
            return std::make_unique<ProcessWorld>(sweep.settings, cell, network->network,
                                                  request.broker_program);
        };
    }
    ResultsFolder results{sweep.settings.output, sweep,
                          request.fresh || (request.only_cell && !request.replace)};
    if (testbed) testbed->leave_word(results.path(), request.fresh);
    Manifest manifest{.build = build_info(),
                      .machine = this_machine(),
                      .started_utc = utc_now_for_people(),
                      .sweep_file = std::filesystem::absolute(request.file).string(),
                      .broker_version = broker_version};
    if (testbed) {
        manifest.hosts_file = std::filesystem::absolute(*request.hosts).string();
        manifest.hosts = testbed->hosts();
    }
    write_text(results.path() / "manifest.json", to_json(manifest, sweep));

    listen_for_interrupts();
    std::vector<Cell> to_run;
    std::ranges::copy_if(cells, std::back_inserter(to_run),
                         [&](const Cell& cell) { return is_to_run(cell, request, results, done); });
    const std::size_t done_before = cells.size() - to_run.size();
    if (done_before > 0) {
        std::printf("%s: %zu of %zu cells were done before; going on\n", results.path().c_str(),
                    done_before, cells.size());
    }
    bool stopped = false;
    {
        ProgressBar bar{stdout, cells.size(), done_before};
        stopped = is_simulated
                      ? !run_at_once(sweep, to_run, make_world,
                                     request.jobs.value_or(std::max(manifest.machine.cores, 1U)),
                                     results, bar)
                      : !run_in_turn(sweep, to_run, make_world, results, bar);
    }

    results.set_in_order();
    const int exit_code = tell(sweep, manifest, results.rows(), results.path());
    if (!stopped) return exit_code;
    std::printf("Interrupted: the same command goes on where it stopped.\n");
    return 130;
}

}  // namespace romano::experiments
