// A real mosquitto of its own, with TLS and credentials: certificates are made by openssl when it
// starts, in its folder. What stands for "the internet" in experiments and tests.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "experiments/process/broker_process.h"

namespace romano::experiments {

class MosquittoServer {
public:
    /// Listens at each of these IP addresses. Throws std::runtime_error when it does not start.
    MosquittoServer(const std::filesystem::path& folder, std::vector<std::string> addresses,
                    std::uint16_t port, bool tls = true);

    void start();
    void kill() { process_.reset(); }

    /// "mqtts://[::1]:8883"
    [[nodiscard]] std::string url(const std::string& address) const;
    [[nodiscard]] std::string ca_file() const { return folder_ / "ca.crt"; }
    [[nodiscard]] std::string password_file() const { return folder_ / "password"; }
    [[nodiscard]] std::uint16_t port() const { return port_; }
    [[nodiscard]] bool has_tls() const { return tls_; }

    static constexpr const char* username = "robots";
    static constexpr const char* password = "wheels";

private:
    void make_certificates() const;
    void write_files() const;

    std::filesystem::path folder_;
    std::vector<std::string> addresses_;
    std::uint16_t port_;
    bool tls_;
    std::unique_ptr<BrokerProcess> process_;
};

}  // namespace romano::experiments
