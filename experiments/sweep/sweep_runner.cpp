#include "experiments/sweep/sweep_runner.h"

#include <unistd.h>

#include <array>
#include <boost/asio/io_context.hpp>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <utility>
#include <vector>

#include "experiments/process/program.h"
#include "experiments/report/configuration.h"
#include "experiments/report/report.h"
#include "experiments/report/summary_table.h"
#include "experiments/sweep/cell_run.h"
#include "experiments/sweep/manifest.h"
#include "experiments/sweep/place.h"
#include "experiments/sweep/progress_bar.h"
#include "experiments/sweep/results_folder.h"

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

void write_text(const std::filesystem::path& file, const std::string& text) {
    std::ofstream stream(file, std::ios::binary | std::ios::trunc);
    if (!(stream << text).flush()) throw SweepError("cannot write `" + file.string() + "`");
}

const Cell& cell_numbered(const Sweep& sweep, std::uint32_t number) {
    if (number == 0 || number > sweep.cells.size()) {
        throw SweepError("--cell " + std::to_string(number) + ": the sweep has cells 1 to " +
                         std::to_string(sweep.cells.size()));
    }
    return sweep.cells[number - 1];
}

/// In order.
std::vector<Cell> cells_to_run(const Sweep& sweep, const SweepRequest& request,
                               const ResultsFolder& results) {
    if (request.replace) return {cell_numbered(sweep, request.only_cell.value())};
    std::vector<Cell> cells;
    for (const Cell& cell : sweep.cells) {
        const RunRow* row = results.row_of(cell);
        if (row == nullptr || (request.retry_failed && !row->ok())) cells.push_back(cell);
    }
    return cells;
}

NetworkPlace claim_network_of(const SweepSettings& settings) {
    if (auto place = claim_network(settings.network)) return std::move(*place);
    if (settings.network.empty()) throw SweepError("no loopback network is free; set `network`");
    throw SweepError("`network = \"" + settings.network +
                     "\"`: another sweep is using it; leave it out, and a free one is taken");
}

}  // namespace

int run_sweep(const SweepRequest& request) {
    Sweep sweep = read_sweep(request.file);
    if (request.only_cell && !request.replace) {
        const Cell only = cell_numbered(sweep, *request.only_cell);
        sweep.cells = {only};
        sweep.settings.output /= "cell-" + std::to_string(only.number) + "-again";
    }
    if (::access(request.broker_program.c_str(), X_OK) != 0) {
        throw SweepError("no broker to run: `" + request.broker_program.string() +
                         "` is no program; build romano-broker, or name it with --broker");
    }
    const NetworkPlace place = claim_network_of(sweep.settings);
    ResultsFolder results{sweep.settings.output, sweep,
                          request.fresh || (request.only_cell && !request.replace)};
    const Manifest manifest{.build = build_info(),
                            .machine = this_machine(),
                            .started_utc = utc_now_for_people(),
                            .sweep_file = std::filesystem::absolute(request.file).string(),
                            .broker_version = version_of(request.broker_program)};
    write_text(results.path() / "manifest.json", to_json(manifest, sweep));

    listen_for_interrupts();
    boost::asio::io_context io{1};
    const std::vector<Cell> cells = cells_to_run(sweep, request, results);
    const auto done_before = sweep.cells.size() - cells.size();
    if (done_before > 0 && !request.only_cell) {
        std::printf("%s: %zu of %zu cells were done before; going on\n", results.path().c_str(),
                    done_before, sweep.cells.size());
    }
    bool stopped = false;
    {
        ProgressBar bar{stdout, sweep.cells.size(), done_before};
        for (const Cell& cell : cells) {
            const CellSurroundings surroundings{
                .io = io,
                .broker_program = request.broker_program,
                .results = results,
                .network = place.network,
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
                stopped = true;
                break;
            }
        }
    }

    const auto report = results.path() / "report.html";
    write_text(report, report_of(sweep, manifest, results.rows(), results.path()));
    if (!results.rows().empty()) {
        std::printf("\n%s\n", to_text(summary_of(configurations_of(results.rows()))).c_str());
    }
    std::printf("Report: %s\n", std::filesystem::absolute(report).c_str());
    if (stopped) {
        std::printf("Interrupted: the same command goes on where it stopped.\n");
        return 130;
    }
    for (const RunRow& row : results.rows()) {
        if (!row.ok() || !row.broken_promises().empty()) return 1;
    }
    return 0;
}

}  // namespace romano::experiments
