// A sweep's first cell, run in a world of virtual time into a folder of its own.
#pragma once

#include <fstream>
#include <functional>
#include <iterator>
#include <memory>
#include <string>
#include <string_view>

#include "experiments/sweep/cell_run.h"
#include "tests/temporary_folder.h"

namespace romano::experiments {

struct RanCell {
    using MakeWorld =
        std::function<std::unique_ptr<CellWorld>(const SweepSettings& settings, const Cell& cell)>;

    RanCell(const std::string& text, const MakeWorld& make_world) {
        Sweep sweep = parse_sweep(text, "small.toml");
        sweep.settings.output = folder / "out";
        const ResultsFolder results{sweep.settings.output, sweep, true};
        row =
            CellRun{
                sweep.settings,
                sweep.cells.front(),
                {.make_world = [&](const Cell& cell) { return make_world(sweep.settings, cell); },
                 .results = results,
                 .on_progress = [](double, std::string_view) {},
                 .is_interrupted = [] { return false; }}}
                .run();
    }
    [[nodiscard]] std::string samples() const {
        std::ifstream stream(folder / "out/samples/cell-0001.csv");
        return {std::istreambuf_iterator<char>(stream), {}};
    }

    tests::TemporaryFolder folder;
    RunRow row;
};

}  // namespace romano::experiments
