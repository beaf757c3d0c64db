#include "broker/daemon/rights_in_force.h"

#include <spdlog/spdlog.h>

#include <utility>
#include <vector>

#include "broker/daemon/refusal.h"
#include "broker/daemon/rights_file.h"

namespace romano::daemon {

RightsInForce::RightsInForce(const std::optional<std::string>& file) : file_(file) {
    if (!file_) {
        rules_ = *rights::parse(rights::usual_rules());
    } else {
        auto read = read_rights_file(*file_);
        if (!read) refuse_option("rights", *file_, read.error());
        rules_ = std::move(*read);
    }
    digest_ = rights::digest_of(rules_);
}

void RightsInForce::read_again() {
    if (!file_) {
        spdlog::info("there is no --rights file to be read again");
        return;
    }
    auto read = read_rights_file(*file_);
    if (!read) {
        spdlog::warn("--rights '{}': {}; the rights of before stay", *file_, read.error());
        return;
    }
    rules_ = std::move(*read);
    digest_ = rights::digest_of(rules_);
    spdlog::info("--rights '{}' is read again: rights {}", *file_, digest_);
}

const broker::Permissions* RightsInForce::for_owners_of_keys(const Protection* protection) {
    if (!file_ && protection == nullptr) return nullptr;
    static const std::vector<rights::KeyOwner> nobody;
    rights_ = std::make_unique<rights::Rights>(
        rules_, protection == nullptr ? nobody : protection->owners());
    return rights_.get();
}

}  // namespace romano::daemon
