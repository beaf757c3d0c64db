#include "experiments/sweep/build_info.h"

namespace romano::experiments {

// CMake defines these for this file alone, so that a commit compiles nothing else anew.
BuildInfo build_info() {
    return {ROMANO_VERSION, ROMANO_COMMIT, ROMANO_COMPILER, ROMANO_BUILD_TYPE};
}

}  // namespace romano::experiments
