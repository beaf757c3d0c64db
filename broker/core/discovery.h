// The broker's part in discovery: MQTT-SN 1.2 section 6.1; G4.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>

#include "broker/core/outbox.h"
#include "broker/core/stranger_answers.h"
#include "broker/core/tables.h"
#include "romano/mqttsn/messages.h"

namespace romano::broker {

class Discovery {
public:
    Discovery(Tables& tables, Outbox& outbox)
        : tables_(tables), outbox_(outbox), answers_(tables.limits().stranger_answers_per_second) {}

    /// GWINFO to all in the radius asked for (6.1b), and to the asker (G4).
    void on_searchgw(const Endpoint& via, const ClientAddress& from,
                     const mqttsn::Searchgw& message, Turn& turn) {
        if (!answers_.allows(turn.now)) {
            tables_.count(Drop::stranger_rate);
            return;
        }
        const mqttsn::Gwinfo info{.gateway_id = tables_.options.gateway_id, .gateway_address = {}};
        outbox_.multicast(message.radius, info, turn);
        outbox_.answer(via, from, info, turn);
    }

    /// ADVERTISE every T_ADV, the first one at once (6.1a).
    void on_tick(Turn& turn) {
        const Duration every = tables_.options.advertise_every;
        if (every <= Duration{0} || turn.now < advertise_at_) return;
        const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(every).count();
        const auto announced =
            static_cast<std::uint16_t>(std::clamp<std::int64_t>(seconds, 1, 0xFFFF));
        outbox_.multicast(0, mqttsn::Advertise{tables_.options.gateway_id, announced}, turn);
        advertise_at_ = turn.now + every;
    }

    [[nodiscard]] Instant next_wakeup() const {
        return tables_.options.advertise_every > Duration{0} ? advertise_at_ : never;
    }

private:
    Tables& tables_;
    Outbox& outbox_;
    StrangerAnswers answers_;
    Instant advertise_at_{};
};

}  // namespace romano::broker
