// What only one experiment of this machine may use at a time: a results folder, a loopback network,
// a DDS domain. The kernel keeps the books, so a claim ends with its process, by kill -9 too, and
// nothing stays behind that somebody would have to clean up.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace romano::experiments {

class Claim {
public:
    /// A name that is claimed once on this machine (in its network namespace, as the addresses and
    /// ports are that it stands for). Empty when somebody else has it.
    [[nodiscard]] static std::optional<Claim> on_name(const std::string& name);
    /// A folder that is there. Empty when somebody else has it.
    [[nodiscard]] static std::optional<Claim> on_folder(const std::filesystem::path& folder);

    ~Claim();
    Claim(Claim&& other) noexcept;
    Claim& operator=(Claim&& other) noexcept;

private:
    explicit Claim(int descriptor) : descriptor_(descriptor) {}

    int descriptor_;  // of the socket or folder; -1 when it was moved
};

}  // namespace romano::experiments
