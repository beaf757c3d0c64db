// Which build this is; for manifests.
#pragma once

#include <string>

namespace romano::experiments {

struct BuildInfo {
    std::string version;   // of the project
    std::string commit;    // as git describes it, "-dirty" with local changes; or "unknown"
    std::string compiler;  // its name and version
    std::string type;      // CMake's build type
};

[[nodiscard]] BuildInfo build_info();

}  // namespace romano::experiments
