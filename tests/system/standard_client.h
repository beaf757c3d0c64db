// A client of DTLS 1.2 that nobody here wrote: openssl s_client or gnutls-cli, whose input is what
// the client says, and whose output is what it hears.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "romano/base/bytes.h"
#include "tests/system/process.h"

namespace romano::system {

class StandardClient {
public:
    using Octets = std::vector<std::uint8_t>;

    /// `command` is the shell's; `folder` is for the pipe to its input.
    StandardClient(const std::filesystem::path& folder, const std::string& command);
    ~StandardClient();
    StandardClient(const StandardClient&) = delete;
    StandardClient& operator=(const StandardClient&) = delete;

    [[nodiscard]] static std::string openssl(const std::string& address_and_port,
                                             const std::string& identity_and_key);
    /// Files of `romano keys certificate`.
    [[nodiscard]] static std::string openssl_with_certificate(
        const std::string& address_and_port, const std::filesystem::path& authority,
        const std::filesystem::path& certificate);
    [[nodiscard]] static std::string gnutls(const std::string& address_and_port,
                                            const std::string& identity_and_key);

    /// One MQTT-SN message.
    void say(const Octets& message) const;
    /// The next MQTT-SN message; empty when none comes in time.
    [[nodiscard]] Octets hear(std::chrono::milliseconds limit = std::chrono::milliseconds{20'000});
    /// Says it until the answer comes, as a client does whose datagrams may be lost.
    [[nodiscard]] bool asks(const Octets& message, const Octets& answer);

private:
    int input_;
    Process process_;
};

}  // namespace romano::system
