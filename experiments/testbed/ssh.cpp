#include "experiments/testbed/ssh.h"

#include <stdlib.h>

#include <stdexcept>
#include <string_view>
#include <system_error>

#include "experiments/process/shell_word.h"

namespace romano::experiments {
namespace {

/// Both streams of a program.
ProgramEnd run_both(const std::string& program, const std::vector<std::string>& arguments) {
    std::vector<std::string> words = {"-c", "exec \"$0\" \"$@\" 2>&1", program};
    words.insert(words.end(), arguments.begin(), arguments.end());
    ProgramEnd end = run_program("/bin/sh", words);
    if (end.exit_code == 127 && end.output.empty()) {
        end.output = "there is no `" + program + "` here: sudo apt install openssh-client";
    }
    return end;
}

/// The last line is the reason; what stands before it are warnings.
std::string reason_in(const std::string& said) {
    std::string text = said;
    while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.pop_back();
    const std::size_t line = text.find_last_of('\n');
    return line == std::string::npos ? text : text.substr(line + 1);
}

}  // namespace

SshFolder::SshFolder() {
    std::string name = std::filesystem::temp_directory_path() / "romano-ssh-XXXXXX";
    if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("cannot make `" + name + "`");
    path_ = name;
}

SshFolder::~SshFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
}

Ssh::Ssh(const Host& host, const SshFolder& folder)
    : host_(host), socket_(folder.path() / host.name) {}

Ssh::~Ssh() {
    if (!std::filesystem::exists(socket_)) return;
    std::vector<std::string> words = options();
    words.insert(words.end(), {"-O", "exit", "--", host_.ssh});
    (void)run_both("ssh", words);
}

std::vector<std::string> Ssh::options() const {
    std::vector<std::string> words = host_.ssh_options;
    for (const std::string& option :
         {std::string{"BatchMode=yes"}, std::string{"ConnectTimeout=5"},
          std::string{"ServerAliveInterval=2"}, std::string{"ServerAliveCountMax=3"},
          std::string{"ControlMaster=auto"}, std::string{"ControlPersist=10"},
          "ControlPath=" + socket_}) {
        words.insert(words.end(), {"-o", option});
    }
    return words;
}

std::vector<std::string> Ssh::arguments(const std::string& line) const {
    std::vector<std::string> words = options();
    words.insert(words.end(), {"-T", "--", host_.ssh, line});
    return words;
}

std::string Ssh::connect() const {
    const ProgramEnd end = run("true");
    if (end.ok()) return {};
    return end.output.empty() ? "ssh ended with exit code " + std::to_string(end.exit_code)
                              : reason_in(end.output);
}

ProgramEnd Ssh::run(const std::string& line) const {
    return run_both("ssh", arguments(line));
}

std::string Ssh::copy(const std::vector<std::filesystem::path>& files,
                      const std::string& folder) const {
    std::vector<std::string> words = options();
    words.insert(words.end(), {"-q", "-p", "--"});
    words.insert(words.end(), files.begin(), files.end());
    words.push_back(scp_target(host_.ssh, folder));
    const ProgramEnd end = run_both("scp", words);
    return end.ok() ? std::string{} : "scp: " + reason_in(end.output);
}

std::string scp_target(const std::string& destination, const std::string& folder) {
    constexpr std::string_view scheme = "ssh://";
    if (destination.starts_with(scheme)) {
        return "scp://" + destination.substr(scheme.size()) + "/" + folder + "/";
    }
    // The colons of an IPv6 address are none before a folder.
    const std::size_t host = destination.rfind('@') + 1;  // 0 without a user
    if (destination.find(':', host) == std::string::npos) return destination + ":" + folder + "/";
    return destination.substr(0, host) + "[" + destination.substr(host) + "]:" + folder + "/";
}

std::string as_root(const std::string& line) {
    return "s=; [ \"$(id -u)\" = 0 ] || s='sudo -n'; $s sh -c " + shell_word(line);
}

std::string romano_host(const Host& host, const std::string& arguments) {
    return "h=" + shell_word(host.folder + "/romano-host") +
           "; [ -x \"$h\" ] || h=romano-host; s=; [ \"$(id -u)\" = 0 ] || s='sudo -n'; exec $s "
           "\"$h\" " +
           arguments;
}

}  // namespace romano::experiments
