#include "experiments/testbed/installation.h"

#include <sys/utsname.h>

#include <algorithm>
#include <array>
#include <vector>

#include "experiments/process/shell_word.h"
#include "experiments/testbed/examination.h"

namespace romano::experiments {
namespace {

namespace fs = std::filesystem;

constexpr std::array program_names = {"romano-host", "romano-broker", "romano-broker-member",
                                      "romano-robot"};
constexpr std::array package_names = {"romano-broker", "romano-robot"};

std::string one_line(const ProgramEnd& end) {
    std::string said = end.output;
    while (!said.empty() && said.back() == '\n') said.pop_back();
    const std::size_t line = said.find_last_of('\n');
    return line == std::string::npos ? said : said.substr(line + 1);
}

/// The newest file of each package for that architecture. Empty: one is missing.
std::vector<fs::path> packages_in(const fs::path& folder, const std::string& architecture) {
    std::vector<fs::path> found;
    for (const std::string name : package_names) {
        fs::path newest;
        std::error_code unreadable;
        for (const auto& entry : fs::directory_iterator(folder, unreadable)) {
            const std::string file = entry.path().filename();
            if (!file.starts_with(name + "_") || !file.ends_with("_" + architecture + ".deb")) {
                continue;
            }
            if (newest.empty() || entry.last_write_time() > fs::last_write_time(newest)) {
                newest = entry.path();
            }
        }
        if (newest.empty()) return {};
        found.push_back(newest);
    }
    return found;
}

class Installation {
public:
    Installation(const Ssh& ssh, const std::function<void(const std::string&)>& tell)
        : ssh_(ssh), tell_(tell) {}

    std::string of_packages(const fs::path& folder) {
        const std::string architecture = one_line(ssh_.run("dpkg --print-architecture"));
        const auto files = packages_in(folder, architecture);
        if (files.empty()) {
            return "`" + folder.string() + "` has no romano-broker_*_" + architecture +
                   ".deb and romano-robot_*_" + architecture +
                   ".deb; make them with cpack (for arm64: cmake/arm64-sysroot, preset arm64)";
        }
        if (auto trouble = bring(files); !trouble.empty()) return trouble;
        tell_("installs packages");
        std::string names;
        for (const fs::path& file : files) {
            names += " " + shell_word(there_ + "/" + file.filename().string());
        }
        // The testbed starts brokers itself, and has only one version of them.
        return finish(
            "DEBIAN_FRONTEND=noninteractive apt-get install -y -q --reinstall "
            "--allow-downgrades nftables" +
            names +
            " && { systemctl disable --now romano-broker romano-robot || true; } && rm -f " +
            programs_there());
    }

    std::string of_programs(const fs::path& folder, const std::string& architecture) {
        utsname here{};
        (void)::uname(&here);
        if (architecture != here.machine) {
            return "it is a " + architecture + " and the programs here are for " + here.machine +
                   "; install its packages: --packages FOLDER (for arm64: cmake/arm64-sysroot, "
                   "preset arm64, cpack)";
        }
        std::vector<fs::path> files;
        for (const char* name : program_names) {
            if (!fs::exists(folder / name)) {
                return "`" + folder.string() + "` has no " + name +
                       "; build it, or name another folder with --programs";
            }
            files.push_back(folder / name);
        }
        if (auto trouble = bring(files); !trouble.empty()) return trouble;
        const std::string to = shell_word(ssh_.host().folder);
        return finish("mkdir -p " + to + " && install -m 755 " + shell_word(there_) + "/* " + to);
    }

private:
    [[nodiscard]] std::string programs_there() const {
        std::string files;
        for (const char* name : program_names) {
            files += shell_word(ssh_.host().folder + "/" + name) + " ";
        }
        return files;
    }

    /// Into a folder of their own there.
    std::string bring(const std::vector<fs::path>& files) {
        const ProgramEnd made = ssh_.run("mktemp -d /tmp/romano-install-XXXXXX");
        there_ = one_line(made);
        if (!made.ok()) return "no folder can be made there: " + there_;
        tell_("copies " + std::to_string(files.size()) + " files");
        return ssh_.copy(files, there_);
    }

    /// Runs the line as root, tidies up, and sees whether the broker runs.
    std::string finish(const std::string& line) {
        const ProgramEnd done = ssh_.run(as_root("(" + line + ") 2>&1"));
        (void)ssh_.run("rm -rf " + shell_word(there_));
        if (!done.ok()) return "installing failed there: " + one_line(done);
        (void)ssh_.run(as_root("timedatectl set-ntp true >/dev/null 2>&1 || true"));
        const std::string member = shell_word(ssh_.host().folder + "/romano-broker-member");
        const ProgramEnd runs = ssh_.run("b=" + member +
                                         "; [ -x \"$b\" ] || b=romano-broker-member; \"$b\" "
                                         "--version");
        if (!runs.ok()) {
            return "romano-broker-member does not run there (" + one_line(runs) +
                   "); packages bring what it needs: --packages FOLDER";
        }
        tell_("has " + one_line(runs));
        return {};
    }

    const Ssh& ssh_;
    const std::function<void(const std::string&)>& tell_;
    std::string there_;
};

}  // namespace

std::string install_on(const Ssh& ssh, const InstallationSource& source,
                       const std::function<void(const std::string&)>& tell) {
    const Ground ground = look_at_ground(ssh);
    if (!ground.trouble.empty()) return ground.trouble;
    Installation installation{ssh, tell};
    return source.packages ? installation.of_packages(*source.packages)
                           : installation.of_programs(source.programs, ground.architecture);
}

}  // namespace romano::experiments
