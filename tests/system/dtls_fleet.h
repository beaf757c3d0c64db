// A fleet at DTLS addresses, clients that nobody here wrote, and our own robots and tools.
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "tests/system/protected_fleet.h"
#include "tests/system/standard_client.h"

namespace romano::system {

struct DtlsFleet : ProtectedFleet {
    DtlsFleet() { scheme = "dtls://"; }

    std::string psk(const std::string& name, keys::Role role = keys::Role::person) {
        EXPECT_EQ(romano({"keys", "psk", keys.own_file(name, role)}), 0) << said;
        return said;
    }
    std::unique_ptr<StandardClient> standard_client(bool is_gnutls, int broker,
                                                    const std::string& identity_and_key) {
        const std::string at = addresses.service(broker);
        const auto pipes = folder / ("client" + std::to_string(++clients_));
        std::filesystem::create_directory(pipes);
        return std::make_unique<StandardClient>(
            pipes, is_gnutls ? StandardClient::gnutls(at, identity_and_key)
                             : StandardClient::openssl(at, identity_and_key));
    }
    std::unique_ptr<StandardClient> client_with_certificate(int broker,
                                                            const std::filesystem::path& of_fleet,
                                                            const std::string& client_id) {
        const auto pipes = folder / ("client" + std::to_string(++clients_));
        std::filesystem::create_directory(pipes);
        return std::make_unique<StandardClient>(
            pipes, StandardClient::openssl_with_certificate(
                       addresses.service(broker), of_fleet / "authority.pem",
                       of_fleet / "certificates" / (client_id + ".pem")));
    }
    std::string metric(int broker, const std::string& name_and_labels) {
        const std::string page = metrics_page_at(addresses.service_endpoint(broker));
        const auto at = page.find('\n' + name_and_labels + ' ');
        if (at == std::string::npos) return {};
        const auto from = at + name_and_labels.size() + 2;
        return page.substr(from, page.find('\n', from) - from);
    }
    std::vector<std::string> at(int broker, const std::string& name,
                                std::vector<std::string> arguments) const {
        const std::string service = addresses.service(broker);
        const auto colon = service.find(':');
        arguments.insert(arguments.end(),
                         {"-h", service.substr(0, colon), "-p", service.substr(colon + 1), "--dtls",
                          "--key", keys.own_file(name, keys::Role::person)});
        return arguments;
    }
    std::unique_ptr<Process> robot_at(int broker, const std::string& keep_alive_s) const {
        return std::make_unique<Process>(
            ROMANO_ROBOT, std::vector<std::string>{
                              "--dtls", "--key", keys.own_file("abcd1234", keys::Role::robot),
                              "--broker", addresses.service(broker), "--keepalive", keep_alive_s});
    }
    bool comes_to_say(int broker, const std::string& name_and_labels, const std::string& value) {
        const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds{30};
        while (std::chrono::steady_clock::now() < deadline) {
            if (metric(broker, name_and_labels) == value) return true;
            std::this_thread::sleep_for(std::chrono::milliseconds{20});  // it is made anew as often
        }
        return false;
    }
    static constexpr const char* handshakes = "romano_dtls_handshakes_total{end=\"agreed\"}";

private:
    int clients_ = 0;
};

}  // namespace romano::system
