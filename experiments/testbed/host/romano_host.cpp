// romano-host: what runs on each machine of a testbed, and does there what `romano testbed` and
// `romano sweep --hosts` say.

#include <CLI/CLI.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <csignal>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>

#include "experiments/sweep/build_info.h"
#include "experiments/testbed/host/host_session.h"
#include "experiments/testbed/host/keeper.h"

namespace {

constexpr const char* examples =
    R"(People need not call this: `romano testbed` and `romano sweep --hosts` do, through ssh.
Examples:
  romano-host session                  (JSON objects on the standard input, one a line)
  romano-host keep /opt/romano-testbed (runs what kept.json in that folder says, until SIGTERM)
All that it has started ends with it, and the addresses that brokers took go.
)";

int serve_session(const std::filesystem::path& programs, const std::string& ssh) {
    using namespace romano::experiments;
    boost::asio::io_context io{1};
    boost::asio::signal_set signals(io, SIGTERM, SIGINT, SIGHUP);
    signals.async_wait([&io](const auto&, int) { io.stop(); });
    const HostSession session{io, programs, parse_ssh_connection(ssh)};
    io.run();
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    using namespace romano::experiments;
    std::signal(SIGPIPE, SIG_IGN);
    CLI::App program{"A machine of a ROMANO testbed: runs brokers and robots there.",
                     "romano-host"};
    program.set_help_flag("--help", "Show this and exit");
    const BuildInfo build = build_info();
    program.set_version_flag("--version", "romano-host " + std::string{build.version} + " (" +
                                              std::string{build.commit} + ")");
    program.require_subcommand(1);
    program.footer(examples);
    const std::filesystem::path programs =
        std::filesystem::read_symlink("/proc/self/exe").parent_path();
    int exit_code = 0;
    std::string ssh;
    std::string folder;
    CLI::App& session =
        *program.add_subcommand("session", "Do what comes through the standard input");
    session.add_option("--ssh", ssh, "sshd's SSH_CONNECTION, which is never cut off");
    session.callback([&] { exit_code = serve_session(programs, ssh); });
    CLI::App& keeper = *program.add_subcommand("keep", "Run what kept.json says, until SIGTERM");
    keeper.add_option("FOLDER", folder, "Where kept.json is, and logs are written")->required();
    keeper.callback([&] { exit_code = keep(folder, programs); });
    try {
        program.parse(argc, argv);
    } catch (const CLI::Success& asked) {
        return program.exit(asked);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "romano-host: %s (see --help)\n", error.what());
        return 2;
    }
    return exit_code;
}
