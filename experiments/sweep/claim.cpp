#include "experiments/sweep/claim.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cassert>
#include <cstddef>
#include <utility>

namespace romano::experiments {

std::optional<Claim> Claim::on_name(const std::string& name) {
    // An abstract socket: a name that begins with a zero octet is in no file system.
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    const std::string whole = "romano/" + name;
    assert(whole.size() < sizeof address.sun_path);
    whole.copy(address.sun_path + 1, whole.size());
    const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + whole.size());
    Claim claim{::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)};
    const auto* any = reinterpret_cast<const sockaddr*>(&address);
    if (::bind(claim.descriptor_, any, size) != 0) return std::nullopt;
    return claim;
}

std::optional<Claim> Claim::on_folder(const std::filesystem::path& folder) {
    Claim claim{::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)};
    if (::flock(claim.descriptor_, LOCK_EX | LOCK_NB) != 0) return std::nullopt;
    return claim;
}

Claim::~Claim() {
    if (descriptor_ >= 0) ::close(descriptor_);
}

Claim::Claim(Claim&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}

Claim& Claim::operator=(Claim&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    return *this;
}

}  // namespace romano::experiments
