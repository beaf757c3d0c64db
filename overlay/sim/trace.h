// What happened in a run: a hash over all of it, and lines of text for whoever asks.
//
// Two runs of one seed have the same hash, or the simulator is broken. Text is only made when
// somebody listens.
#pragma once

#include <concepts>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <type_traits>

#include "overlay/cluster/messages.h"
#include "romano/base/bytes.h"
#include "romano/base/endpoint.h"
#include "romano/base/time.h"

namespace romano::sim {

class Trace {
public:
    using Listener = std::function<void(std::string_view line)>;

    void listen(Listener listener) { listener_ = std::move(listener); }
    [[nodiscard]] std::uint64_t hash() const { return hash_; }

    template <typename... Parts>
    void note(Instant now, const Parts&... parts) {
        mix(static_cast<std::uint64_t>(now.time_since_epoch().count()));
        (take(parts), ...);
        if (!listener_) return;
        std::string line = text_of(now);
        ((line += ' ', append(line, parts)), ...);
        listener_(line);
    }

private:
    void mix(std::uint64_t value) {
        hash_ = (hash_ ^ value) * 0x100000001b3ULL;
        hash_ ^= hash_ >> 29U;
    }

    template <typename T>
    requires std::integral<T> || std::is_enum_v<T>
    void take(T number) { mix(static_cast<std::uint64_t>(number)); }
    void take(std::string_view text) {
        mix(text.size());
        for (const char c : text) mix(static_cast<unsigned char>(c));
    }
    void take(Bytes octets) { take(as_text(octets)); }
    void take(const Endpoint& endpoint) { mix(endpoint.hash()); }
    void take(const cluster::ClusterMessage& message) { mix(message.index()); }

    template <typename T>
    requires std::integral<T> || std::is_enum_v<T>
    static void append(std::string& line, T number) {
        line += std::to_string(static_cast<std::uint64_t>(number));
    }
    static void append(std::string& line, std::string_view text) { line += text; }
    static void append(std::string& line, Bytes datagram);  // as an MQTT-SN message
    static void append(std::string& line, const Endpoint& endpoint);
    static void append(std::string& line, const cluster::ClusterMessage& message);
    static std::string text_of(Instant now);

    std::uint64_t hash_ = 0xcbf29ce484222325ULL;
    Listener listener_;
};

/// "10.0.1.1:1883"; the simulator's addresses are IPv4.
[[nodiscard]] std::string to_text(const Endpoint& endpoint);

}  // namespace romano::sim
