#include "overlay/cluster/agreement/settings_comparison.h"

#include <algorithm>
#include <chrono>
#include <string_view>
#include <utility>

#include "romano/base/fnv1a.h"

namespace romano::cluster {
namespace {

constexpr std::size_t others_most = 1'000;
constexpr std::size_t longest_value = 200;
constexpr std::size_t longest_believed_value = 256;  // that is believed of a peer

std::string text_of(const PredefinedTopics& predefined) {
    std::string text;
    for (const auto& [id, topic] : predefined) {
        text += (text.empty() ? "" : ",") + std::to_string(static_cast<unsigned>(id)) + '=' + topic;
    }
    return text;
}

std::string text_of(std::vector<std::string> names) {
    std::ranges::sort(names);
    std::string text;
    for (const std::string& name : names) text += (text.empty() ? "" : ",") + name;
    return text;
}

std::string milliseconds(Duration time) {
    return std::to_string(std::chrono::duration_cast<std::chrono::milliseconds>(time).count());
}

/// At most so many octets of it, and of UTF-8 whole characters.
std::string cut(std::string text, std::size_t most) {
    constexpr std::string_view mark = "...";
    if (text.size() <= most) return text;
    std::size_t end = most - mark.size();
    while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U) --end;
    return text.substr(0, end) + std::string{mark};
}

Setting setting(std::string name, std::string value) {
    const std::uint32_t digest = fnv1a<std::uint32_t>(std::string_view{value});
    return {
        .name = std::move(name), .value = cut(std::move(value), longest_value), .digest = digest};
}

/// Of all of them.
std::uint32_t digest_of(const std::vector<Setting>& settings) {
    std::string all;
    for (const Setting& each : settings) {
        all += each.name + ' ' + std::to_string(each.digest) + '\n';
    }
    return fnv1a<std::uint32_t>(std::string_view{all});
}

}  // namespace

std::vector<Setting> agreed_settings(const ClusterOptions& options,
                                     const PredefinedTopics& predefined) {
    return {setting("predefined", text_of(predefined)),
            setting("profile", options.profile + " (beacon-ms " +
                                   milliseconds(options.beacon_every) + ", detection-timeout-ms " +
                                   milliseconds(options.detection_timeout) + ")"),
            setting("detector", options.detector),
            setting("elector", options.elector),
            setting("voters", text_of(options.voters)),
            setting("acks", options.acks == all_peers ? "all" : std::to_string(options.acks)),
            setting("rights", {}),  // SettingsComparison::change()
            setting("version", options.version)};
}

std::uint32_t digest_of(const PredefinedTopics& predefined) {
    return predefined.empty() ? 0 : fnv1a<std::uint32_t>(std::string_view{text_of(predefined)});
}

SettingsComparison::SettingsComparison(std::string name, std::vector<Setting> own)
    : name_(std::move(name)), own_(std::move(own)), digest_(digest_of(own_)) {}

void SettingsComparison::on_told(BrokerId from, const std::vector<Setting>& settings) {
    if (others_.size() >= others_most && !others_.contains(from)) return;
    std::vector<Setting> known;
    for (const Setting& ours : own_) {
        const auto theirs = std::ranges::find(settings, ours.name, &Setting::name);
        if (theirs == settings.end()) continue;
        known.push_back({ours.name, cut(theirs->value, longest_believed_value), theirs->digest});
    }
    Other& other = others_[from];
    if (digest_of(other.settings) != digest_of(known)) other = {.settings = std::move(known)};
}

void SettingsComparison::on_beacon(Effects& effects, const Beacon& beacon) {
    const auto found = others_.find(beacon.log.broker);
    if (found == others_.end()) return;
    Other& other = found->second;
    if (std::exchange(other.is_compared, true)) return;
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
    for (auto& [id, other] : others_) other.is_compared = false;
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
