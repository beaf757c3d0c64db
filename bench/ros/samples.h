// What a node leaves of its messages: one record for each that it published or heard.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

namespace romano::bench::ros {

struct Sample {
    std::uint32_t publisher = 0;
    std::uint32_t sequence = 0;
    std::int64_t sent_ns = 0;   // CLOCK_BOOTTIME, one for all nodes of a machine
    std::int64_t heard_ns = 0;  // 0: this is the publisher's own record
};

/// Throws std::runtime_error.
void write_samples(const std::vector<Sample>& samples, const std::filesystem::path& file);
/// Empty when there is no such file: its node was killed.
[[nodiscard]] std::vector<Sample> read_samples(const std::filesystem::path& file);

}  // namespace romano::bench::ros
