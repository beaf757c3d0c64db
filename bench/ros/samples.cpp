#include "bench/ros/samples.h"

#include <fstream>
#include <stdexcept>
#include <type_traits>

namespace romano::bench::ros {

static_assert(std::is_trivially_copyable_v<Sample> && sizeof(Sample) == 24);

void write_samples(const std::vector<Sample>& samples, const std::filesystem::path& file) {
    std::ofstream out(file, std::ios::binary);
    out.write(reinterpret_cast<const char*>(samples.data()),
              static_cast<std::streamsize>(samples.size() * sizeof(Sample)));
    if (!out.flush()) throw std::runtime_error("cannot write `" + file.string() + "`");
}

std::vector<Sample> read_samples(const std::filesystem::path& file) {
    std::error_code missing;
    const auto octets = std::filesystem::file_size(file, missing);
    if (missing) return {};
    std::vector<Sample> samples(octets / sizeof(Sample));
    std::ifstream in(file, std::ios::binary);
    in.read(reinterpret_cast<char*>(samples.data()),
            static_cast<std::streamsize>(samples.size() * sizeof(Sample)));
    return samples;
}

}  // namespace romano::bench::ros
