#include "overlay/cluster/agreement/agreed_settings.h"

#include <algorithm>
#include <chrono>
#include <string_view>
#include <utility>

#include "romano/base/fnv1a.h"

namespace romano::cluster {
namespace {

constexpr std::size_t longest_value = 200;

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

}  // namespace

Setting setting(std::string name, std::string value) {
    const std::uint32_t digest = fnv1a<std::uint32_t>(std::string_view{value});
    return {
        .name = std::move(name), .value = cut(std::move(value), longest_value), .digest = digest};
}

std::string cut(std::string text, std::size_t most) {
    constexpr std::string_view mark = "...";
    if (text.size() <= most) return text;
    std::size_t end = most - mark.size();
    while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U) --end;
    return text.substr(0, end) + std::string{mark};
}

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

std::uint32_t digest_of(const std::vector<Setting>& settings) {
    std::string all;
    for (const Setting& each : settings) {
        all += each.name + ' ' + std::to_string(each.digest) + '\n';
    }
    return fnv1a<std::uint32_t>(std::string_view{all});
}

std::uint32_t digest_of(const PredefinedTopics& predefined) {
    return predefined.empty() ? 0 : fnv1a<std::uint32_t>(std::string_view{text_of(predefined)});
}

}  // namespace romano::cluster
