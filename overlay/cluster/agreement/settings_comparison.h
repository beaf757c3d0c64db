// Settings that must agree and do not: people are told by name, at both brokers, once. Beacons
// carry a digest; whoever hears another one asks for the values, and gives its own.
#pragma once

#include <cstdint>
#include <map>
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

    /// Peers learn of it by the next beacon; what was known of theirs is compared anew.
    void change(const std::string& name, const std::string& value);

    /// Of the own settings, for the beacon.
    [[nodiscard]] std::uint32_t digest() const { return digest_; }
    /// Of a peer that hears us.
    void on_beacon(Effects& effects, const Beacon& beacon);
    void on_told(Effects& effects, BrokerId from, const std::string& name,
                 const SettingsTold& told);
    /// Empty when all agrees, for all that is known.
    [[nodiscard]] std::vector<Difference> differences_with(BrokerId peer) const;
    [[nodiscard]] std::string own_value(const std::string& name) const;
    /// Empty while it is not known.
    [[nodiscard]] std::string value_at(BrokerId peer, const std::string& name) const;

private:
    struct Other {
        std::uint32_t digest = 0;
        Instant asked_at{};
        bool is_known = false;
        std::vector<Difference> differences{};
    };

    void compare(Effects& effects, const std::string& name, Other& other,
                 const SettingsTold& told) const;

    std::string name_;
    std::vector<Setting> own_;
    std::uint32_t digest_;
    std::map<BrokerId, Other> others_;  // whose digest is another one
};

}  // namespace romano::cluster
