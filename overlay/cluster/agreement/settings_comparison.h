// Settings that must agree and do not: people are told by name, at both brokers, once.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "overlay/cluster/agreement/agreed_settings.h"
#include "overlay/cluster/effects.h"

namespace romano::cluster {

struct Difference {
    std::string setting;
    std::string ours;
    std::string theirs;
};

class SettingsComparison {
public:
    SettingsComparison(std::string name, std::vector<Setting> own)
        : name_(std::move(name)), own_(std::move(own)), digest_(digest_of(own_)) {}

    /// Peers learn of it by the next beacon; theirs are compared anew.
    void change(const std::string& name, const std::string& value);

    [[nodiscard]] const std::vector<Setting>& own() const { return own_; }
    /// Of them, for the beacon.
    [[nodiscard]] std::uint32_t digest() const { return digest_; }
    void on_told(BrokerId from, const std::vector<Setting>& settings);
    /// Of a peer that hears us: people are told where its settings differ.
    void on_beacon(Effects& effects, const Beacon& beacon);
    /// Empty when all agrees, for all that is known.
    [[nodiscard]] std::vector<Difference> differences_with(BrokerId peer) const;
    [[nodiscard]] std::string own_value(const std::string& name) const;
    /// Empty while it is not known.
    [[nodiscard]] std::string value_at(BrokerId peer, const std::string& name) const;

private:
    struct Other {
        std::vector<Setting> settings{};
        std::vector<Difference> differences{};
    };

    std::string name_;
    std::vector<Setting> own_;
    std::uint32_t digest_;
    std::map<BrokerId, Other> others_;
    std::set<BrokerId> not_compared_;  // of them
};

}  // namespace romano::cluster
