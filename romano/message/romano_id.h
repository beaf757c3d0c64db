// The ROMANO id: the last 8 hexadecimal digits of a device's IPv6 address, lower case (paper,
// section "Requirements"). It is the name of the topic that reaches this device alone, and its
// MQTT-SN client id.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace romano::message {

class RomanoId {
public:
    static constexpr std::size_t size = 8;

    constexpr RomanoId() { digits_.fill('0'); }

    /// From the 16 octets of an IPv6 address: its last four octets, written out.
    [[nodiscard]] static constexpr RomanoId from_ipv6(std::span<const std::uint8_t, 16> address) {
        constexpr std::string_view hexadecimal = "0123456789abcdef";
        RomanoId id;
        for (std::size_t i = 0; i < size / 2; ++i) {
            const std::uint8_t octet = address[12 + i];
            id.digits_[2 * i] = hexadecimal[octet >> 4U];
            id.digits_[2 * i + 1] = hexadecimal[octet & 0x0FU];
        }
        return id;
    }

    /// Exactly eight lower-case hexadecimal digits.
    [[nodiscard]] static constexpr bool is_id(std::string_view text) {
        for (const char c : text) {
            if (!(c >= '0' && c <= '9') && !(c >= 'a' && c <= 'f')) return false;
        }
        return text.size() == size;
    }

    /// Nothing when `text` is no id.
    [[nodiscard]] static constexpr std::optional<RomanoId> parse(std::string_view text) {
        if (!is_id(text)) return std::nullopt;
        RomanoId id;
        for (std::size_t i = 0; i < size; ++i) id.digits_[i] = text[i];
        return id;
    }

    [[nodiscard]] constexpr std::string_view text() const { return {digits_.data(), size}; }

    friend bool operator==(const RomanoId&, const RomanoId&) = default;
    friend auto operator<=>(const RomanoId&, const RomanoId&) = default;

private:
    std::array<char, size> digits_{};
};

}  // namespace romano::message
