// Two applications of the ROMANO paper (section "Application Implementation Examples") on simulated
// robots. Each writes <name>.csv, <name>.svg and the gnuplot script of the picture into a folder,
// and throws std::runtime_error when the robots do not end where they should.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace romano::experiments {

struct ApplicationOptions {
    std::string host = "127.0.0.1";
    std::uint16_t port = 1883;
    std::filesystem::path output = ".";
};

/// Movement messages to subgroups: two teams of three robots, told apart by the topic that the
/// operator made each subscribe to, drive two figures; a message to one robot's id moves it alone.
void run_group_control(const ApplicationOptions& options);

/// One robot drives a course and tells where it is; two others listen and copy its path, each from
/// its own place.
void run_path_copy(const ApplicationOptions& options);

}  // namespace romano::experiments
