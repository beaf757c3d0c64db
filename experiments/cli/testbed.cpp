#include "experiments/cli/testbed.h"

#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "experiments/process/shell_word.h"
#include "experiments/testbed/doctor.h"
#include "experiments/testbed/examination.h"
#include "experiments/testbed/fleet_at_work.h"
#include "experiments/testbed/hosts_file.h"
#include "experiments/testbed/installation.h"

namespace romano::experiments {
namespace {

constexpr const char* testbed_examples = R"(Examples:
  romano testbed check hosts.toml                        (what is wrong, and what to do)
  romano testbed install hosts.toml --packages build/arm64
  romano testbed start hosts.toml                        (brokers there, until stop)
  romano testbed logs hosts.toml --host pi3 --lines 50
  romano testbed stop hosts.toml
  romano sweep experiments/demo.toml --hosts hosts.toml  (an experiment there)
From SD card to report, and what hosts.toml may say: experiments/TESTBED.md.
Exit code: 0; 1 when a machine has a problem; 2 when nothing was tried.
)";

struct TestbedOptions {
    std::filesystem::path hosts;
    bool as_json = false;
    std::string packages;
    std::string programs;
    std::string host;
    unsigned lines = 20;
};

/// On a terminal alone, and on the other stream: results can be piped.
void tell_progress(const std::string& what) {
    if (::isatty(STDERR_FILENO) != 0) std::fprintf(stderr, "%s...\n", what.c_str());
}

int check(const TestbedOptions& options) {
    const Testbed testbed = read_hosts(options.hosts);
    const Connections connections{testbed};
    const auto seen = examine(testbed, connections, testbed.port, tell_progress);
    const auto findings = findings_of(testbed, seen, own_version());
    if (options.as_json) {
        std::printf("%s\n", to_json(testbed, seen, findings).dump(2).c_str());
    } else {
        std::fputs(to_text(findings).c_str(), stdout);
        if (!has_problem(findings)) {
            std::printf("%zu hosts are ready\n", testbed.hosts.size());
        }
    }
    return has_problem(findings) ? 1 : 0;
}

int install(const TestbedOptions& options) {
    const Testbed testbed = read_hosts(options.hosts);
    const Connections connections{testbed};
    InstallationSource source{.programs = options.programs, .packages = {}};
    if (options.programs.empty()) {
        source.programs = std::filesystem::read_symlink("/proc/self/exe").parent_path();
    }
    if (!options.packages.empty()) source.packages = options.packages;
    int exit_code = 0;
    for (std::size_t i = 0; i < testbed.hosts.size(); ++i) {
        const std::string& name = testbed.hosts[i].name;
        const std::string trouble =
            install_on(connections[i], source, [&](const std::string& what) {
                std::printf("%s: %s\n", name.c_str(), what.c_str());
                std::fflush(stdout);
            });
        if (trouble.empty()) continue;
        std::printf("%s: %s\n", name.c_str(), trouble.c_str());
        exit_code = 1;
    }
    return exit_code;
}

void tell_line(const std::string& line) {
    std::printf("%s\n", line.c_str());
    std::fflush(stdout);
}

int tell_troubles(const std::vector<std::string>& troubles) {
    for (const std::string& trouble : troubles) tell_line(trouble);
    return troubles.empty() ? 0 : 1;
}

int start(const TestbedOptions& options) {
    const Testbed testbed = read_hosts(options.hosts);
    const Connections connections{testbed};
    const int exit_code = tell_troubles(start_fleet(testbed, connections, tell_line));
    if (exit_code == 0) {
        tell_line("Look at it: romano brokers -h " + testbed.addresses().front() + " -p " +
                  std::to_string(testbed.port));
    }
    return exit_code;
}

int stop(const TestbedOptions& options) {
    const Testbed testbed = read_hosts(options.hosts);
    const Connections connections{testbed};
    return tell_troubles(stop_fleet(testbed, connections, tell_line));
}

int logs(const TestbedOptions& options) {
    const Testbed testbed = read_hosts(options.hosts);
    const Connections connections{testbed};
    bool is_known = false;
    int exit_code = 0;
    for (std::size_t i = 0; i < testbed.hosts.size(); ++i) {
        const Host& host = testbed.hosts[i];
        if (!options.host.empty() && host.name != options.host) continue;
        is_known = true;
        const std::string logs = shell_word(host.folder + "/logs") + "/*.txt";
        const ProgramEnd end =
            connections[i].run("tail -n " + std::to_string(options.lines) + " " + logs);
        std::printf("%s:\n%s", host.name.c_str(), end.output.c_str());
        if (!end.ok()) exit_code = 1;
    }
    if (is_known) return exit_code;
    throw SettingError("--host `" + options.host + "`: `" + options.hosts.string() +
                       "` has no such host");
}

}  // namespace

void add_testbed(CLI::App& program, int& exit_code) {
    auto options = std::make_shared<TestbedOptions>();
    CLI::App& testbed = *program.add_subcommand(
        "testbed", "Prepare machines of your own for experiments, through ssh");
    testbed.set_help_flag("--help", "Show this and examples, and exit");
    testbed.require_subcommand(1);
    testbed.footer(testbed_examples);
    const auto add = [&](const char* name, const char* what, int (*run)(const TestbedOptions&)) {
        CLI::App& command = *testbed.add_subcommand(name, what);
        command.set_help_flag("--help", "Show this and examples, and exit");
        command.add_option("HOSTS", options->hosts, "The hosts file (TOML)")->required();
        command.footer(testbed_examples);
        command.callback([options, run, &exit_code] { exit_code = run(*options); });
        return &command;
    };
    add("check", "Say what is wrong with the machines, before anything runs", check)
        ->add_flag("--json", options->as_json, "Print facts and findings as JSON");
    CLI::App& installing = *add("install", "Put the programs there", install);
    CLI::Option* packages =
        installing
            .add_option("--packages", options->packages,
                        "Install the Debian packages of this folder (cpack makes them)")
            ->type_name("FOLDER");
    installing
        .add_option("--programs", options->programs,
                    "Copy the programs of this folder (default: those beside this program)")
        ->type_name("FOLDER")
        ->excludes(packages);
    add("start", "Run the brokers and robots of the hosts file there, until stop", start);
    add("stop", "End them", stop);
    CLI::App& reading = *add("logs", "Show the last lines of what they print", logs);
    reading.add_option("--host", options->host, "Of this host alone")->type_name("NAME");
    reading.add_option("--lines", options->lines, "So many of each")
        ->check(CLI::Range(1U, 1'000'000U))
        ->capture_default_str();
}

}  // namespace romano::experiments
