// An MCAP file on disk: read in any order, and appended to so that whatever happens to the program
// or to the disk, whole chunks stand in it.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>

#include "experiments/mcap/file_walk.h"

namespace romano::experiments {

/// One sentence, which names the file.
struct RecordingError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

class RecordingFile final : public mcap::OctetSource {
public:
    /// Throws RecordingError.
    [[nodiscard]] static RecordingFile open(const std::string& path);
    /// Refuses a file that is there.
    [[nodiscard]] static RecordingFile create(const std::string& path);

    RecordingFile(RecordingFile&& other) noexcept;
    RecordingFile& operator=(RecordingFile&&) = delete;
    ~RecordingFile();

    [[nodiscard]] Bytes read(std::uint64_t offset, std::size_t octets) override;
    [[nodiscard]] std::uint64_t size() const override { return size_; }

    /// All of it, or nothing: what a full disk took of it is taken away again. Throws
    /// RecordingError.
    void append(Bytes octets);
    /// What is not wanted any more at its end. Throws RecordingError.
    void cut_back_to(std::uint64_t size);

private:
    RecordingFile(std::string path, int descriptor);

    std::string path_;
    int descriptor_;
    std::uint64_t size_ = 0;
    mcap::Octets window_;  // a part of the file
    std::uint64_t window_at_ = 0;
};

}  // namespace romano::experiments
