#include "broker/daemon/rights_in_force.h"

#include <spdlog/spdlog.h>

#include <utility>
#include <vector>

#include "broker/daemon/refusal.h"
#include "broker/daemon/rights_file.h"

namespace romano::daemon {

RightsInForce::RightsInForce(const std::optional<std::string>& file) : file_(file) {
    if (!file_) {
        own_ = *rights::parse(rights::usual_rules());
    } else {
        auto read = read_rights_file(*file_);
        if (!read) refuse_option("rights", *file_, read.error());
        own_ = std::move(*read);
    }
    put_in_force();
}

void RightsInForce::put_in_force() {
    digest_ = rights::digest_of(set_ ? *set_ : own_);
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
    own_ = std::move(*read);
    put_in_force();
    if (set_) {
        spdlog::warn(
            "--rights '{}' is read again, and does not count: rights {} were set for all brokers "
            "(romano rights set); `romano rights reset` takes them back",
            *file_, digest_);
    } else {
        spdlog::info("--rights '{}' is read again: rights {}", *file_, digest_);
    }
}

bool RightsInForce::look(const broker::BrokerCore& core) {
    const auto found = core.retained(rights::rights_topic);
    const broker::MessagePtr message = found.empty() ? broker::MessagePtr{} : found.front();
    if (message == message_) return false;
    message_ = message;
    if (!message) {
        set_.reset();
        put_in_force();
        spdlog::info("rights that were set for all brokers are taken back: rights {}", digest_);
        return true;
    }
    auto rules = rights::parse(as_text(message->payload));
    if (!rules) {  // a peer of another version let it pass
        spdlog::warn("rights that were set for all brokers, line {}: {}; the rights of before stay",
                     rules.error().line, rules.error().what);
        return false;
    }
    set_ = std::move(*rules);
    put_in_force();
    spdlog::info("rights {} were set for all brokers", digest_);
    return true;
}

const broker::Permissions* RightsInForce::for_owners_of_keys(const Protection* protection) {
    if (!file_ && !set_ && protection == nullptr) return nullptr;
    static const std::vector<rights::KeyOwner> nobody;
    rights_ = std::make_unique<rights::Rights>(
        set_ ? *set_ : own_, protection == nullptr ? nobody : protection->owners());
    return rights_.get();
}

}  // namespace romano::daemon
