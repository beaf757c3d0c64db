#include "overlay/cluster/agreement/settings_comparison.h"

#include <algorithm>
#include <utility>

namespace romano::cluster {
namespace {

constexpr std::size_t others_most = 1'000;
constexpr std::size_t longest_believed_value = 256;  // that is believed of a peer

}  // namespace

void SettingsComparison::on_told(BrokerId from, const std::vector<Setting>& settings) {
    if (others_.size() >= others_most && !others_.contains(from)) return;
    std::vector<Setting> known;
    for (const Setting& ours : own_) {
        const auto theirs = std::ranges::find(settings, ours.name, &Setting::name);
        if (theirs == settings.end()) continue;
        known.push_back({ours.name, cut(theirs->value, longest_believed_value), theirs->digest});
    }
    const auto [other, is_new] = others_.try_emplace(from);
    const bool is_changed = digest_of(other->second.settings) != digest_of(known);
    if (is_changed) other->second = {.settings = std::move(known)};
    if (is_new || is_changed) not_compared_.insert(from);
}

void SettingsComparison::on_beacon(Effects& effects, const Beacon& beacon) {
    if (not_compared_.erase(beacon.log.broker) == 0) return;
    Other& other = others_.at(beacon.log.broker);
    other.differences.clear();
    for (const Setting& theirs : other.settings) {
        const Setting& ours = *std::ranges::find(own_, theirs.name, &Setting::name);
        if (theirs.digest == ours.digest) continue;
        effects.local.push_back(Notice{.text = "the brokers disagree about " + ours.name + ": " +
                                               name_ + " has '" + ours.value + "', " + beacon.name +
                                               " has '" + theirs.value +
                                               "'; give all brokers the same",
                                       .is_warning = true});
        other.differences.push_back({ours.name, ours.value, theirs.value});
    }
}

void SettingsComparison::change(const std::string& name, const std::string& value) {
    const auto own = std::ranges::find(own_, name, &Setting::name);
    const Setting changed = setting(name, value);
    if (own->digest == changed.digest) return;
    *own = changed;
    digest_ = digest_of(own_);
    for (const auto& [id, other] : others_) not_compared_.insert(id);
}

std::string SettingsComparison::own_value(const std::string& name) const {
    return std::ranges::find(own_, name, &Setting::name)->value;
}

std::string SettingsComparison::value_at(BrokerId peer, const std::string& name) const {
    const auto other = others_.find(peer);
    if (other == others_.end()) return {};
    const auto& settings = other->second.settings;
    const auto theirs = std::ranges::find(settings, name, &Setting::name);
    return theirs == settings.end() ? std::string{} : theirs->value;
}

std::vector<Difference> SettingsComparison::differences_with(BrokerId peer) const {
    const auto other = others_.find(peer);
    return other == others_.end() ? std::vector<Difference>{} : other->second.differences;
}

}  // namespace romano::cluster
