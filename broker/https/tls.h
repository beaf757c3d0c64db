// Both ends of TLS: 1.2 or 1.3, suites with forward secrecy and authenticated encryption alone.
#pragma once

#include <boost/asio/ssl/context.hpp>
#include <filesystem>
#include <optional>

namespace romano::https {

/// Of a server that proves itself with `certificate`: a PEM file with its certificate, those of
/// whoever vouches for it, if need be, and its private key; nobody but its owner may read it.
/// No session is resumed, so none is kept. Throws keys::KeyError.
[[nodiscard]] boost::asio::ssl::context server_tls(const std::filesystem::path& certificate);

/// Of a client that believes whom `authority`, a PEM file, vouches for; without one, those that
/// the system believes. Throws keys::KeyError.
[[nodiscard]] boost::asio::ssl::context client_tls(
    const std::optional<std::filesystem::path>& authority);

}  // namespace romano::https
