// The configuration file: TOML, read by toml++, whose keys are the program's long options.
//
// Strict: an unknown key, a key twice, a value of another type than the option has, and anything
// that is no TOML is refused, with the line.
#pragma once

#include <CLI/CLI.hpp>
#include <istream>
#include <string>
#include <vector>

namespace romano::daemon {

class ConfigFile : public CLI::ConfigBase {
public:
    explicit ConfigFile(const CLI::App& app) : app_(app) {}

    /// Throws Refusal; without the file's name, which the caller knows.
    std::vector<CLI::ConfigItem> from_config(std::istream& input) const override;

private:
    const CLI::App& app_;
};

/// All options as a file that changes nothing: each with its help, commented out with its default.
[[nodiscard]] std::string default_config(const CLI::App& app);

}  // namespace romano::daemon
