// Answers other clients' searches when no gateway does: MQTT-SN 1.2 section 6.1e. Beside a
// Discovery, for clients that do not want to be silent; it hears what the Discovery hears.
#pragma once

#include <cstddef>
#include <cstdint>

#include "romano/base/bytes.h"
#include "romano/base/random.h"
#include "romano/base/time.h"
#include "romano/client/discovery.h"

namespace romano::client {

class SearchAnswer {
public:
    static constexpr std::size_t largest_datagram = 21;

    SearchAnswer(const Discovery& discovery, std::uint64_t seed,
                 Duration t_gwinfo = mqttsn::default_t_gwinfo)
        : discovery_(discovery), random_(seed), t_gwinfo_(t_gwinfo) {}

    /// After the Discovery's.
    void on_datagram(Instant now, Bytes datagram);

    /// As of Discovery.
    [[nodiscard]] std::size_t on_tick(Instant now, MutableBytes out);
    [[nodiscard]] Instant next_wakeup() const { return due_; }

private:
    const Discovery& discovery_;
    Random random_;
    Duration t_gwinfo_;
    Instant due_ = never;
};

}  // namespace romano::client
