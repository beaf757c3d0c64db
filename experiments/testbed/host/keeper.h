// Brokers and robots that go on when the connection that started them has ended: `romano testbed
// start` has them kept by a process of their own, `stop` ends that.
//
// Its folder holds kept.json (what runs), keeper.pid and logs/NAME.txt.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

#include "experiments/testbed/program_order.h"

namespace romano::experiments {

/// Starts the keeper. {"kept": true}, or with "trouble".
[[nodiscard]] nlohmann::json keep_running(const KeptPrograms& order,
                                          const std::filesystem::path& programs);
/// {"kept": bool, "programs": [{"name", "serves", "has_ended", "said"}...]}; "said" is its last
/// line.
[[nodiscard]] nlohmann::json what_is_kept(const std::filesystem::path& folder);
/// Ends it, with all that it keeps. {"kept": false}, or with "trouble".
[[nodiscard]] nlohmann::json end_keeping(const std::filesystem::path& folder);

/// The keeper itself, until SIGTERM. Its exit code.
int keep(const std::filesystem::path& folder, const std::filesystem::path& programs);

}  // namespace romano::experiments
