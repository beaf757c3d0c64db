// The operator's program: publish, subscribe, look at the brokers, run experiments.

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>

#include "experiments/cli/apply.h"
#include "experiments/cli/broker_options.h"
#include "experiments/cli/brokers.h"
#include "experiments/cli/cell.h"
#include "experiments/cli/compare.h"
#include "experiments/cli/control.h"
#include "experiments/cli/cost.h"
#include "experiments/cli/keys.h"
#include "experiments/cli/load.h"
#include "experiments/cli/loops.h"
#include "experiments/cli/paper.h"
#include "experiments/cli/pub.h"
#include "experiments/cli/record.h"
#include "experiments/cli/replay.h"
#include "experiments/cli/results.h"
#include "experiments/cli/rights.h"
#include "experiments/cli/robots.h"
#include "experiments/cli/simulate.h"
#include "experiments/cli/status.h"
#include "experiments/cli/sub.h"
#include "experiments/cli/sweep.h"
#include "experiments/cli/testbed.h"
#include "experiments/cli/web.h"
#include "experiments/sweep/build_info.h"

int main(int argc, char** argv) {
    using namespace romano::experiments;
    constexpr int cannot_be_done = 2;
    int exit_code = 0;
    CLI::App program{"ROMANO without a central broker: the operator's tools.", "romano"};
    program.set_help_flag("--help", "Show this and exit");
    const BuildInfo build = build_info();
    program.set_version_flag("--version", "romano " + std::string{build.version} + " (" +
                                              std::string{build.commit} + ")");
    program.require_subcommand(0, 1);
    program.footer("Each has its own --help with examples: romano pub --help\n");
    add_pub(program, exit_code);
    add_sub(program, exit_code);
    add_brokers(program, exit_code);
    add_status(program, exit_code);
    add_load(program, exit_code);
    add_robots(program, exit_code);
    add_web(program, exit_code);
    add_record(program, exit_code);
    add_replay(program, exit_code);
    add_robot_commands(program, exit_code);
    add_control(program, exit_code);
    add_keys(program, exit_code);
    add_rights(program, exit_code);
    add_apply(program, exit_code);
    add_sweep(program, exit_code);
    add_testbed(program, exit_code);
    add_report(program, exit_code);
    add_merge(program, exit_code);
    add_compare(program, exit_code);
    add_simulate(program, exit_code);
    add_cost(program, exit_code);
    add_loops(program, exit_code);
    add_paper(program, exit_code);
    add_cell(program, exit_code);
    try {
        program.parse(argc, argv);
        if (program.get_subcommands().empty()) {
            throw CommandError(
                "a subcommand is needed: pub, sub, brokers, status, robots... (see --help)");
        }
    } catch (const CLI::Success& asked) {  // --help, --version
        return program.exit(asked);
    } catch (const CLI::Error& error) {
        std::fprintf(stderr, "romano: %s (see --help)\n", error.what());
        return cannot_be_done;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "romano: %s\n", error.what());
        return cannot_be_done;
    }
    return exit_code;
}
