// Places in a file that one process at a time holds; the kernel frees them when it ends.
#pragma once

#include <filesystem>

namespace romano::keys {

class LockFile {
public:
    /// Made when it is missing. Throws KeyError.
    explicit LockFile(const std::filesystem::path& file);
    ~LockFile();
    LockFile(const LockFile&) = delete;
    LockFile& operator=(const LockFile&) = delete;

    /// False when another process, or another LockFile of this one, holds the place.
    [[nodiscard]] bool try_take(unsigned place);
    /// Waits for it.
    void take(unsigned place);
    void give_back(unsigned place);

private:
    int descriptor_;
};

}  // namespace romano::keys
