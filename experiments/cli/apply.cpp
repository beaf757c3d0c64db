#include "experiments/cli/apply.h"

#include <cstdio>
#include <memory>
#include <stdexcept>

#include "experiments/applications/applications.h"
#include "experiments/cli/broker_options.h"

namespace romano::experiments {
namespace {

constexpr const char* examples = R"(Examples:
  romano apply group-control                   (six robots, two teams: group_control.svg, .csv)
  romano apply path-copy -h 127.0.0.2 -o out   (a leader, two followers: out/path_copy.svg, .csv)

Lengths are in millimetres, angles in degrees.
)";

struct ApplyOptions {
    std::string application;
    ApplicationOptions run;
    std::string output = ".";
};

}  // namespace

void add_apply(CLI::App& program, int& exit_code) {
    auto options = std::make_shared<ApplyOptions>();
    CLI::App& command = *program.add_subcommand(
        "apply",
        "Run an application of the ROMANO paper on simulated robots, and draw their trails");
    command.set_help_flag("--help", "Show this and examples, and exit");
    command.add_option("application", options->application, "group-control or path-copy")
        ->check(CLI::IsMember({"group-control", "path-copy"}))
        ->required();
    command.add_option("-h,--host", options->run.host, "A broker with a ROMANO server")
        ->capture_default_str();
    command.add_option("-p,--port", options->run.port, "Its UDP port")
        ->check(CLI::Range(1, 65535))
        ->capture_default_str();
    command.add_option("-o,--output", options->output, "The folder for picture and numbers")
        ->capture_default_str();
    command.footer(examples);
    command.callback([options, &exit_code] {
        options->run.output = options->output;
        try {
            if (options->application == "path-copy") {
                run_path_copy(options->run);
            } else {
                run_group_control(options->run);
            }
        } catch (const std::runtime_error& failed) {
            throw CommandError(failed.what());
        }
        std::printf("wrote %s\n",
                    (options->run.output /
                     (options->application == "path-copy" ? "path_copy.svg" : "group_control.svg"))
                        .c_str());
        exit_code = 0;
    });
}

}  // namespace romano::experiments
