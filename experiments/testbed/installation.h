// Puts the programs on the machines of a testbed: the project's Debian packages, or the programs of
// a build as they are.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "experiments/testbed/ssh.h"

namespace romano::experiments {

struct InstallationSource {
    std::filesystem::path programs;                 // the folder with romano-broker and so on
    std::optional<std::filesystem::path> packages;  // the folder with .deb files, instead
};

/// Empty, or a sentence that says what to do. `tell` hears each step.
[[nodiscard]] std::string install_on(const Ssh& ssh, const InstallationSource& source,
                                     const std::function<void(const std::string&)>& tell);

}  // namespace romano::experiments
