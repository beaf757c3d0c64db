#include "romano/keys/lock_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

#include "romano/keys/key_error.h"

namespace romano::keys {
namespace {

/// Open file descriptions have these locks, not processes.
int set_lock(int descriptor, int command, short type, unsigned place) {
    struct flock lock {};
    lock.l_type = type;
    lock.l_whence = SEEK_SET;
    lock.l_start = place;
    lock.l_len = 1;
    int done = -1;
    do {
        done = fcntl(descriptor, command, &lock);
    } while (done != 0 && errno == EINTR);
    return done;
}

}  // namespace

LockFile::LockFile(const std::filesystem::path& file)
    : descriptor_(open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600)) {
    if (descriptor_ < 0) {
        throw KeyError(file.string() + ": cannot be made (" + std::strerror(errno) +
                       "); keys lie in a folder that their program may write to");
    }
}

LockFile::~LockFile() {
    close(descriptor_);
}

bool LockFile::try_take(unsigned place) {
    return set_lock(descriptor_, F_OFD_SETLK, F_WRLCK, place) == 0;
}

void LockFile::take(unsigned place) {
    if (set_lock(descriptor_, F_OFD_SETLKW, F_WRLCK, place) != 0) {
        throw KeyError(std::string{"a key file cannot be locked ("} + std::strerror(errno) + ")");
    }
}

void LockFile::give_back(unsigned place) {
    (void)set_lock(descriptor_, F_OFD_SETLK, F_UNLCK, place);
}

}  // namespace romano::keys
