// What a broker's clients may: its --rights file, or the usual rules, with the owners of its keys.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "broker/core/permissions.h"
#include "broker/daemon/protection.h"
#include "broker/rights/rights.h"

namespace romano::daemon {

class RightsInForce {
public:
    /// Reads the file. Throws Refusal.
    explicit RightsInForce(const std::optional<std::string>& file);

    /// The file may have changed. One that is wrong changes nothing; people are told.
    void read_again();

    /// What the broker core is to ask from now on; asked for anew when rules or keys have changed.
    /// Null where neither is given: then everybody may do everything.
    [[nodiscard]] const broker::Permissions* for_owners_of_keys(const Protection* protection);

    /// rights::digest_of(), to be compared between brokers.
    [[nodiscard]] const std::string& digest() const { return digest_; }

private:
    std::optional<std::string> file_;
    rights::Rules rules_;
    std::string digest_;
    std::unique_ptr<rights::Rights> rights_;
};

}  // namespace romano::daemon
