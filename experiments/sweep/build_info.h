// Which build this is; for manifests.
#pragma once

#include <string_view>

namespace romano::experiments {

struct BuildInfo {
    std::string_view version;   // of the project
    std::string_view commit;    // as git describes it, "-dirty" with local changes; or "unknown"
    std::string_view compiler;  // its name and version
    std::string_view type;      // CMake's build type
};

[[nodiscard]] BuildInfo build_info();

}  // namespace romano::experiments
