#include "experiments/recording/recording_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace romano::experiments {
namespace {

constexpr std::size_t window_octets = 256UL << 10U;

[[noreturn]] void fail(const std::string& path, int error) {
    throw RecordingError("`" + path + "`: " + std::strerror(error));
}

}  // namespace

RecordingFile RecordingFile::open(const std::string& path) {
    // A pipe would make it wait for a writer.
    const int descriptor = ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    if (descriptor < 0) fail(path, errno);
    return {path, descriptor};
}

RecordingFile RecordingFile::create(const std::string& path) {
    const int descriptor = ::open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor < 0 && errno == EEXIST) {
        throw RecordingError("`" + path +
                             "` is there already: a recording is never written over; give "
                             "another name");
    }
    if (descriptor < 0) fail(path, errno);
    return {path, descriptor};
}

RecordingFile::RecordingFile(std::string path, int descriptor)
    : path_(std::move(path)), descriptor_(descriptor) {
    struct stat status {};
    if (::fstat(descriptor_, &status) != 0) fail(path_, errno);
    if (!S_ISREG(status.st_mode)) throw RecordingError("`" + path_ + "`: must be a file");
    size_ = static_cast<std::uint64_t>(status.st_size);
}

RecordingFile::RecordingFile(RecordingFile&& other) noexcept
    : path_(std::move(other.path_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      size_(other.size_) {}

RecordingFile::~RecordingFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
}

Bytes RecordingFile::read(std::uint64_t offset, std::size_t octets) {
    if (offset >= size_) return {};
    octets = static_cast<std::size_t>(std::min<std::uint64_t>(octets, size_ - offset));
    const bool is_there = offset >= window_at_ && offset - window_at_ <= window_.size() &&
                          octets <= window_.size() - (offset - window_at_);
    if (!is_there) {
        window_.resize(std::max(octets, window_octets));
        window_at_ = offset;
        std::size_t got = 0;
        while (got < octets) {
            const ssize_t part = ::pread(descriptor_, window_.data() + got, window_.size() - got,
                                         static_cast<off_t>(offset + got));
            if (part < 0 && errno == EINTR) continue;
            if (part < 0) fail(path_, errno);
            if (part == 0) break;  // somebody has cut it meanwhile
            got += static_cast<std::size_t>(part);
        }
        window_.resize(got);
    }
    const auto from = static_cast<std::size_t>(offset - window_at_);
    return Bytes{window_}.subspan(from, std::min(octets, window_.size() - from));
}

void RecordingFile::append(Bytes octets) {
    window_.clear();
    std::uint64_t at = size_;
    while (!octets.empty()) {
        const ssize_t part =
            ::pwrite(descriptor_, octets.data(), octets.size(), static_cast<off_t>(at));
        if (part < 0 && errno == EINTR) continue;
        if (part <= 0) {
            const int error = part < 0 ? errno : ENOSPC;
            if (::ftruncate(descriptor_, static_cast<off_t>(size_)) != 0) fail(path_, errno);
            fail(path_, error);
        }
        octets = octets.subspan(static_cast<std::size_t>(part));
        at += static_cast<std::uint64_t>(part);
    }
    size_ = at;
}

void RecordingFile::cut_back_to(std::uint64_t size) {
    window_.clear();
    if (::ftruncate(descriptor_, static_cast<off_t>(size)) != 0) fail(path_, errno);
    size_ = size;
}

}  // namespace romano::experiments
