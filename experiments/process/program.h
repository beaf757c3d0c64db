// Another program, run to its end. There is no shell: each argument reaches the program as it is,
// whatever characters it has, and nothing of ours but the three streams.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace romano::experiments {

struct ProgramEnd {
    int exit_code = 127;  // as a shell tells it: 127 when there is no such program
    std::string output;   // what it said on its standard output; the standard error is dropped

    [[nodiscard]] bool ok() const { return exit_code == 0; }
};

/// `program` is a path, or a name to look for on PATH. Runs in `folder`, if one is given.
[[nodiscard]] ProgramEnd run_program(const std::string& program,
                                     const std::vector<std::string>& arguments,
                                     const std::filesystem::path& folder = {});

}  // namespace romano::experiments
