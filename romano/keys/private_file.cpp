#include "romano/keys/private_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include "romano/keys/key_error.h"

namespace romano::keys {
namespace {

constexpr std::size_t most_octets = std::size_t{16} << 20U;

class File {
public:
    File(const std::filesystem::path& path, int flags)
        : path_(path), descriptor_(open(path.c_str(), flags | O_CLOEXEC, 0600)) {}
    ~File() {
        if (descriptor_ >= 0) close(descriptor_);
    }
    File(const File&) = delete;
    File& operator=(const File&) = delete;

    [[nodiscard]] int descriptor() const { return descriptor_; }
    [[noreturn]] void fail(const char* what) const {
        throw KeyError(path_.string() + ": cannot be " + what + " (" + std::strerror(errno) + ")");
    }

private:
    const std::filesystem::path& path_;
    int descriptor_;
};

void write_all(const File& file, std::string_view text) {
    while (!text.empty()) {
        const auto written = write(file.descriptor(), text.data(), text.size());
        if (written < 0 && errno == EINTR) continue;
        if (written <= 0) file.fail("written");
        text.remove_prefix(static_cast<std::size_t>(written));
    }
}

}  // namespace

std::string read_private_file(const std::filesystem::path& path) {
    const File file(path, O_RDONLY);
    struct stat status {};
    if (file.descriptor() < 0 || fstat(file.descriptor(), &status) != 0) file.fail("read");
    if (!S_ISREG(status.st_mode)) throw KeyError(path.string() + ": is no file; give a key file");
    if ((status.st_mode & 077U) != 0) {
        std::array<char, 8> mode{};
        std::snprintf(mode.data(), mode.size(), "%o", status.st_mode & 0777U);
        throw KeyError(path.string() + ": others may read or write it (mode " + mode.data() +
                       "); say: chmod 600 " + path.string());
    }
    std::string text;
    std::array<char, 4096> part{};
    for (;;) {
        const auto size = read(file.descriptor(), part.data(), part.size());
        if (size < 0 && errno == EINTR) continue;
        if (size < 0) file.fail("read");
        if (size == 0) return text;
        text.append(part.data(), static_cast<std::size_t>(size));
        if (text.size() > most_octets) throw KeyError(path.string() + ": is too long for keys");
    }
}

void write_private_file(const std::filesystem::path& path, const std::string& text) {
    const std::filesystem::path next = path.string() + ".next";
    unlink(next.c_str());  // of a writer that was killed, perhaps with another mode
    try {
        const File file(next, O_WRONLY | O_CREAT | O_EXCL);
        if (file.descriptor() < 0) file.fail("written");
        write_all(file, text);
        if (fsync(file.descriptor()) != 0) file.fail("written");
    } catch (const KeyError&) {
        unlink(next.c_str());  // it would fill what is left of a full disk
        throw;
    }
    if (rename(next.c_str(), path.c_str()) != 0) {
        throw KeyError(path.string() + ": cannot be written (" + std::strerror(errno) + ")");
    }
    const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
    const File entry(folder, O_RDONLY | O_DIRECTORY);
    if (entry.descriptor() < 0 || fsync(entry.descriptor()) != 0) entry.fail("written");
}

}  // namespace romano::keys
