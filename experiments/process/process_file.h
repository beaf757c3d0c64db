// What proc(5) says of one process, which may end while it is read.
#pragma once

#include <sys/types.h>

#include <istream>
#include <string>

namespace romano::experiments {

/// "cmdline", "stat"... of that process. Empty when it has ended, also when it ends meanwhile.
[[nodiscard]] std::string process_file(pid_t pid, const std::string& name);
/// Of one that was opened.
[[nodiscard]] std::string process_file(std::istream& opened);

}  // namespace romano::experiments
