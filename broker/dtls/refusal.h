// Why a record is not accepted, or not sent; each reason is counted.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace romano::dtls {

enum class Refusal : std::uint8_t {
    // not accepted
    malformed,          // no record of DTLS 1.2, or one that has no business in its epoch
    unknown_sender,     // no association with that address, or of that Connection ID
    replayed,           // a number that was there before, or is too old to tell
    bad_tag,            // forged, damaged, or by another key
    forwarded,          // a forwarder encapsulation inside: a client speaks for itself alone
    foreign_client_id,  // a message in another client's name
    handshake_failed,   // wrong key, unknown identity, or what OpenSSL does not understand
    handshake_rate,     // a ClientHello that came when as many were begun as may be at once
    // not sent
    no_association,  // the client has closed it, or its key was withdrawn
    unstored,        // no number may be used before the shell has stored the reserve
    used_up,         // too many brokers spoke, or this one has no place: a new handshake is due
    too_long,        // for a record
    unanswered,      // more than may go to a new address that has answered nothing yet
};
inline constexpr std::array<std::string_view, 13> refusal_names = {
    "malformed",         "unknown_sender",   "replayed",       "bad_tag",        "forwarded",
    "foreign_client_id", "handshake_failed", "handshake_rate", "no_association", "unstored",
    "used_up",           "too_long",         "unanswered"};

class Refusals {
public:
    void count(Refusal why) { ++counts_[static_cast<std::size_t>(why)]; }
    [[nodiscard]] std::uint64_t of(Refusal why) const {
        return counts_[static_cast<std::size_t>(why)];
    }

private:
    std::array<std::uint64_t, refusal_names.size()> counts_{};
};

}  // namespace romano::dtls
