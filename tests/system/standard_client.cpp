#include "tests/system/standard_client.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <stdexcept>
#include <utility>

namespace romano::system {
namespace {

using namespace std::chrono_literals;

int open_pipe(const std::filesystem::path& pipe) {
    // Both ends, so that neither the shell nor we wait for the other to open it.
    if (::mkfifo(pipe.c_str(), 0600) != 0) throw std::runtime_error("no pipe " + pipe.string());
    return ::open(pipe.c_str(), O_RDWR | O_CLOEXEC | O_NONBLOCK);
}

/// "anna 0011..." as `romano keys psk` prints it.
std::pair<std::string, std::string> apart(const std::string& identity_and_key) {
    const auto space = identity_and_key.find(' ');
    return {identity_and_key.substr(0, space), identity_and_key.substr(space + 1, 32)};
}

}  // namespace

// Each octet becomes a line, as soon as it is there.
StandardClient::StandardClient(const std::filesystem::path& folder, const std::string& command)
    : input_(open_pipe(folder / "input")),
      process_("/bin/sh", {"-c", command + " <'" + (folder / "input").string() +
                                     "' | stdbuf -oL od -An -v -tx1 -w1"}) {}

StandardClient::~StandardClient() {
    ::close(input_);
}

std::string StandardClient::openssl(const std::string& address_and_port,
                                    const std::string& identity_and_key) {
    const auto [identity, key] = apart(identity_and_key);
    return "openssl s_client -dtls1_2 -quiet -no_ign_eof -psk_identity " + identity + " -psk " +
           key + " -connect " + address_and_port + " 2>/dev/null";
}

std::string StandardClient::openssl_with_certificate(const std::string& address_and_port,
                                                     const std::filesystem::path& authority,
                                                     const std::filesystem::path& certificate) {
    return "openssl s_client -dtls1_2 -quiet -no_ign_eof -verify_return_error -CAfile '" +
           authority.string() + "' -cert '" + certificate.string() + "' -key '" +
           certificate.string() + "' -connect " + address_and_port + " 2>/dev/null";
}

std::string StandardClient::gnutls(const std::string& address_and_port,
                                   const std::string& identity_and_key) {
    const auto [identity, key] = apart(identity_and_key);
    const auto colon = address_and_port.find(':');
    return "gnutls-cli --udp --logfile=/dev/null --pskusername " + identity + " --pskkey " + key +
           " --priority 'NORMAL:-KX-ALL:+PSK:-VERS-ALL:+VERS-DTLS1.2' -p " +
           address_and_port.substr(colon + 1) + ' ' + address_and_port.substr(0, colon) +
           " 2>/dev/null";
}

void StandardClient::say(const Octets& message) const {
    if (::write(input_, message.data(), message.size()) < 0) throw std::runtime_error("no pipe");
}

StandardClient::Octets StandardClient::hear(std::chrono::milliseconds limit) {
    Octets message;
    while (message.empty() || message.size() < message[0]) {
        const std::string line = process_.next_line(limit);
        if (line.empty()) return {};
        message.push_back(static_cast<std::uint8_t>(std::strtoul(line.c_str(), nullptr, 16)));
    }
    return message;
}

bool StandardClient::asks(const Octets& message, const Octets& answer) {
    const auto deadline = std::chrono::steady_clock::now() + 30s;
    while (std::chrono::steady_clock::now() < deadline) {
        say(message);
        for (Octets heard = hear(1s); !heard.empty(); heard = hear(1s)) {
            if (heard == answer) return true;
        }
    }
    return false;
}

}  // namespace romano::system
