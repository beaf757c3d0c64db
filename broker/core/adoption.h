// Sessions that come from another home and go to one (design: hand-off, take-over).
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "broker/core/delivery_flow.h"
#include "broker/core/lifecycle.h"
#include "broker/core/subscriptions.h"
#include "broker/core/tables.h"

namespace romano::broker {

class Adoption {
public:
    Adoption(Tables& tables, DeliveryFlow& deliveries, Lifecycle& lifecycle,
             Subscriptions& subscriptions)
        : tables_(tables),
          deliveries_(deliveries),
          lifecycle_(lifecycle),
          subscriptions_(subscriptions) {}

    /// See BrokerCore::adopt.
    bool adopt(SessionImage image, std::vector<MessagePtr> missed,
               const std::optional<LogPosition>& moved, std::optional<SessionImage> ours,
               Turn& turn);
    /// See BrokerCore::caught_up.
    SessionImage caught_up(SessionImage image, std::span<const MessagePtr> missed);
    /// See BrokerCore::forget_logs.
    void forget_logs(const std::function<bool(const LogId&)>& are_over, Actions& out);
    /// See BrokerCore::release.
    std::optional<SessionImage> release(std::string_view client_id, Actions& out);
    /// See BrokerCore::move_away.
    std::optional<SessionImage> move_away(std::string_view client_id, const LogId& to,
                                          std::uint64_t epochs, Actions& out);

private:
    void restore(Session& session, SessionImage& image, Turn& turn);
    void restore(Session& session, Delivery& delivery);
    [[nodiscard]] bool is_to_come(const LogPosition& position) const;

    Tables& tables_;
    DeliveryFlow& deliveries_;
    Lifecycle& lifecycle_;
    Subscriptions& subscriptions_;
};

}  // namespace romano::broker
