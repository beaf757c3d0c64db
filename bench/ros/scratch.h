// A folder that goes with all that is in it when its owner does, however that ends.
#pragma once

#include <filesystem>
#include <system_error>
#include <utility>

namespace romano::bench::ros {

class Scratch {
public:
    /// Whoever writes there first makes it.
    explicit Scratch(std::filesystem::path folder) : folder_(std::move(folder)) {}
    ~Scratch() {
        std::error_code ignored;
        std::filesystem::remove_all(folder_, ignored);
    }
    Scratch(const Scratch&) = delete;
    Scratch& operator=(const Scratch&) = delete;

    [[nodiscard]] const std::filesystem::path& folder() const { return folder_; }

private:
    std::filesystem::path folder_;
};

}  // namespace romano::bench::ros
