#include "overlay/cluster/agreement/settings_comparison.h"

#include <algorithm>
#include <utility>

namespace romano::cluster {
namespace {

constexpr std::size_t others_most = 1'000;
constexpr std::size_t longest_believed_value = 256;  // that is believed of a peer

}  // namespace

void SettingsComparison::on_beacon(Effects& effects, const Beacon& beacon) {
    const BrokerId from = beacon.log.broker;
    if (beacon.settings == digest_) {
        others_.erase(from);
        return;
    }
    if (others_.size() >= others_most && !others_.contains(from)) return;
    Other& other = others_[from];
    if (std::exchange(other.digest, beacon.settings) != beacon.settings) other = {beacon.settings};
    if (other.is_known || effects.now < other.asked_at + effects.times.settings_asked_every())
        return;
    other.asked_at = effects.now;
    effects.peers.push_back({from, SettingsTold{.settings = own_, .asks = true}});
}

void SettingsComparison::on_told(Effects& effects, BrokerId from, const std::string& name,
                                 const SettingsTold& told) {
    if (told.asks) {
        effects.peers.push_back({from, SettingsTold{.settings = own_, .asks = false}});
    }
    const auto other = others_.find(from);
    if (other == others_.end() || other->second.is_known) return;
    if (digest_of(told.settings) != other->second.digest) return;  // of an earlier life
    compare(effects, name, other->second, told);
}

void SettingsComparison::compare(Effects& effects, const std::string& name, Other& other,
                                 const SettingsTold& told) const {
    other.is_known = true;
    for (const Setting& ours : own_) {
        const auto theirs = std::ranges::find(told.settings, ours.name, &Setting::name);
        if (theirs == told.settings.end() || theirs->digest == ours.digest) continue;
        const std::string value = cut(theirs->value, longest_believed_value);
        effects.local.push_back(Notice{.text = "the brokers disagree about " + ours.name + ": " +
                                               name_ + " has '" + ours.value + "', " + name +
                                               " has '" + value + "'; give all brokers the same",
                                       .is_warning = true});
        other.differences.push_back({ours.name, ours.value, value});
    }
}

void SettingsComparison::change(const std::string& name, const std::string& value) {
    const auto own = std::ranges::find(own_, name, &Setting::name);
    const Setting changed = setting(name, value);
    if (own->digest == changed.digest) return;
    *own = changed;
    digest_ = digest_of(own_);
    others_.clear();
}

std::string SettingsComparison::own_value(const std::string& name) const {
    return std::ranges::find(own_, name, &Setting::name)->value;
}

std::string SettingsComparison::value_at(BrokerId peer, const std::string& name) const {
    const auto other = others_.find(peer);
    if (other == others_.end()) return own_value(name);
    if (!other->second.is_known) return {};
    const auto& differences = other->second.differences;
    const auto difference = std::ranges::find(differences, name, &Difference::setting);
    return difference == differences.end() ? own_value(name) : difference->theirs;
}

std::vector<Difference> SettingsComparison::differences_with(BrokerId peer) const {
    const auto other = others_.find(peer);
    return other == others_.end() ? std::vector<Difference>{} : other->second.differences;
}

}  // namespace romano::cluster
