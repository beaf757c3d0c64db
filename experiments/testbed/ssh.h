// OpenSSH's programs, towards one machine: one connection for everything that is said to it
// (ControlMaster), which ends by itself ten seconds after the last word. Nobody is asked for a
// password: keys, or an agent, must do.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "experiments/process/program.h"
#include "experiments/testbed/hosts_file.h"

namespace romano::experiments {

/// The folder with the sockets of ssh's connections, gone with it: paths of sockets are short.
class SshFolder {
public:
    SshFolder();
    ~SshFolder();
    SshFolder(const SshFolder&) = delete;
    SshFolder& operator=(const SshFolder&) = delete;
    [[nodiscard]] const std::filesystem::path& path() const { return path_; }

private:
    std::filesystem::path path_;
};

class Ssh {
public:
    Ssh(const Host& host, const SshFolder& folder);
    /// The connection ends.
    ~Ssh();
    Ssh(const Ssh&) = delete;
    Ssh& operator=(const Ssh&) = delete;

    [[nodiscard]] const Host& host() const { return host_; }

    /// Connects, unless it has. Empty, or what ssh said.
    [[nodiscard]] std::string connect() const;
    /// A line for the shell there; what it says on both streams.
    [[nodiscard]] ProgramEnd run(const std::string& line) const;
    /// Files from here into a folder there. Empty, or what scp said.
    [[nodiscard]] std::string copy(const std::vector<std::filesystem::path>& files,
                                   const std::string& folder) const;
    /// For `ssh`, to run that line there.
    [[nodiscard]] std::vector<std::string> arguments(const std::string& line) const;

private:
    [[nodiscard]] std::vector<std::string> options() const;

    const Host& host_;
    std::string socket_;
};

/// A folder there, for scp, by a destination as ssh takes it: "pi@[fd00::11]:/tmp/".
[[nodiscard]] std::string scp_target(const std::string& destination, const std::string& folder);
/// As root there, if need be through sudo: "sudo -n ".
[[nodiscard]] std::string as_root(const std::string& line);
/// The line that runs romano-host there: the one in the host's folder, or else a package's.
[[nodiscard]] std::string romano_host(const Host& host, const std::string& arguments);

}  // namespace romano::experiments
