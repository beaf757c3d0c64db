#include "experiments/cli/apply.h"

#include <array>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "experiments/applications/applications.h"
#include "experiments/cli/broker_options.h"
#include "romano/cli/loopback_network.h"

namespace romano::experiments {
namespace {

constexpr const char* apply_examples = R"(Applications, at a broker that runs:
  group-control   six robots in two teams, told apart by the topics they subscribe to
  path-copy       one robot drives and tells where it is, two others copy its path
  radio-distance  two robots disperse and keep the strength of their radio link (a modelled radio)
With brokers of their own (--broker, --domain, --network):
  bridge          two networks, IPv6 and IPv4, over MQTT through mosquitto with TLS; a leader dies
  roaming         robots drive between the cells of three brokers and talk to the nearest; takes
                  four minutes (--brief: one)

Examples:
  romano apply group-control                   (group_control.svg, .csv)
  romano apply path-copy -h 127.0.0.2 -o out   (out/path_copy.svg, .csv)
  romano apply roaming -o out --seed 7         (out/roaming.svg, .csv, the brokers' traces)

Lengths are in millimetres, angles in degrees, signals in dBm.
)";

struct Application {
    std::string_view name;
    std::string_view picture;
    void (*run)(const ApplicationOptions&);
};
constexpr std::array applications = {
    Application{"group-control", "group_control.svg", run_group_control},
    Application{"path-copy", "path_copy.svg", run_path_copy},
    Application{"radio-distance", "radio_distance.svg", run_radio_distance},
    Application{"bridge", "bridge.svg", run_bridge},
    Application{"roaming", "roaming.svg", run_roaming},
};

struct ApplyOptions {
    std::string application;
    ApplicationOptions run;
    std::string output = ".";
    std::string broker_program;
};

std::vector<std::string> names() {
    std::vector<std::string> all;
    all.reserve(std::size(applications));
    for (const Application& each : applications) all.emplace_back(each.name);
    return all;
}

void add_options(CLI::App& command, ApplyOptions& options) {
    command.set_help_flag("--help", "Show this and examples, and exit");
    command.add_option("application", options.application, "Which one")
        ->check(CLI::IsMember(names()))
        ->required();
    command.add_option("-h,--host", options.run.host, "A broker with a ROMANO server")
        ->capture_default_str();
    command.add_option("-p,--port", options.run.port, "Its UDP port")
        ->check(CLI::Range(1, 65535))
        ->capture_default_str();
    command.add_option("-o,--output", options.output, "The folder for picture and numbers")
        ->capture_default_str();
    command
        .add_option("--broker", options.broker_program,
                    "The program of brokers that it starts (default: romano-broker beside this "
                    "program)")
        ->check(CLI::ExistingFile);
    command.add_option("--domain", options.run.domain, "Their DDS domain, and the next")
        ->check(CLI::Range(0, 229))
        ->capture_default_str();
    command
        .add_option("--network", options.run.network, "The first three octets of their addresses")
        ->check(loopback_network())
        ->capture_default_str();
    command.add_option("--seed", options.run.seed, "Of the modelled radio")->capture_default_str();
    command.add_flag("--brief", options.run.brief, "roaming: fewer robots, a shorter way");
}

}  // namespace

void add_apply(CLI::App& program, int& exit_code) {
    auto options = std::make_shared<ApplyOptions>();
    CLI::App& command = *program.add_subcommand(
        "apply", "Run an application of the ROMANO paper on simulated robots, and draw a picture");
    add_options(command, *options);
    command.footer(apply_examples);
    command.callback([options, &exit_code] {
        options->run.output = options->output;
        options->run.broker_program =
            options->broker_program.empty()
                ? std::filesystem::read_symlink("/proc/self/exe").parent_path() / "romano-broker"
                : std::filesystem::path{options->broker_program};
        for (const Application& each : applications) {
            if (each.name != options->application) continue;
            try {
                each.run(options->run);
            } catch (const std::runtime_error& failed) {
                throw CommandError(failed.what());
            }
            const auto picture = options->run.output / each.picture;
            const auto numbers = std::filesystem::path{picture}.replace_extension("csv");
            std::printf("wrote %s and %s\n", picture.c_str(), numbers.c_str());
        }
        exit_code = 0;
    });
}

}  // namespace romano::experiments
