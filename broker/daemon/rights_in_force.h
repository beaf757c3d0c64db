// What a broker's clients may: the rules that were set for all brokers (rights::rights_topic), or
// its
// --rights file, or the usual rules; with the owners of its keys.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "broker/core/broker_core.h"
#include "broker/core/permissions.h"
#include "broker/daemon/protection.h"
#include "broker/rights/rights.h"

namespace romano::daemon {

class RightsInForce {
public:
    /// Reads the file. Throws Refusal.
    explicit RightsInForce(const std::optional<std::string>& file);

    /// The file may have changed. One that is wrong changes nothing; people are told. While rules
    /// are set for all brokers it is read for later.
    void read_again();
    /// Rules may have been set for all brokers, or taken back. True when other rules are in force.
    [[nodiscard]] bool look(const broker::BrokerCore& core);

    /// What the broker core is to ask from now on; asked for anew when rules or keys have changed.
    /// Null where neither is given: then everybody may do everything.
    [[nodiscard]] const broker::Permissions* for_owners_of_keys(const Protection* protection);

    /// rights::digest_of(), to be compared between brokers.
    [[nodiscard]] const std::string& digest() const { return digest_; }

private:
    void put_in_force();

    std::optional<std::string> file_;
    rights::Rules own_;                 // of the file, or the usual ones
    broker::MessagePtr message_;        // that was looked at last
    std::optional<rights::Rules> set_;  // for all brokers
    std::string digest_;                // of the rules in force
    std::unique_ptr<rights::Rights> rights_;
};

}  // namespace romano::daemon
