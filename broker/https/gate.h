// The gate of an HTTP server that other machines reach: TLS, and a token with each request.
//
// Who has no token costs a bounded share of the server's time: so many handshakes at once and so
// many begun in a second, at most half of each by one address, and others wait for their turn; and
// a wrong token is answered late.
#pragma once

#include <array>
#include <boost/asio/ip/address.hpp>
#include <boost/asio/ssl/context.hpp>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "broker/https/gate_files.h"
#include "broker/https/token.h"

namespace romano::https {

class Gate {
public:
    using Address = boost::asio::ip::address;
    using Time = std::chrono::steady_clock::time_point;

    static constexpr std::size_t most_handshakes = 16;  // at once
    static constexpr std::size_t most_in_a_second = 32;
    static constexpr std::chrono::milliseconds next_look{20};  // of who waits for his turn
    static constexpr std::chrono::milliseconds wait_of_a_wrong_token{1000};

    struct Counts {
        std::uint64_t crowded = 0;  // whose turn did not come in time
        std::uint64_t handshakes_failed = 0;
        std::uint64_t wrong_tokens = 0;
        std::uint64_t without_token = 0;  // as the first request of a browser
    };

    /// Reads them. Throws keys::KeyError.
    explicit Gate(const GateFiles& files);

    [[nodiscard]] boost::asio::ssl::context& tls() { return tls_; }

    /// Whether who comes from there may begin a handshake now. Each that may ends it once.
    [[nodiscard]] bool begins_handshake(const Address& from, Time now);
    void turns_away() { ++counts_.crowded; }
    void ends_handshake(const Address& from, bool is_agreed);
    /// Whether the request with this Authorization, or with none, is served.
    [[nodiscard]] bool lets_in(std::string_view authorization, const Address& from);

    [[nodiscard]] const Counts& counts() const { return counts_; }
    /// Who showed a wrong token last.
    [[nodiscard]] const Address& last_wrong() const { return last_wrong_; }

private:
    struct Begun {
        Address from;
        Time at = Time::min();
    };

    boost::asio::ssl::context tls_;
    Token token_;
    std::vector<Address> handshakes_;              // who is in one
    std::array<Begun, most_in_a_second> begun_{};  // a ring of the last ones
    std::size_t oldest_ = 0;
    Counts counts_;
    Address last_wrong_;
};

}  // namespace romano::https
