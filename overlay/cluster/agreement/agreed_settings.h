// What all brokers of a cluster must be told alike, as people wrote it: compared by digest, told by
// name when it differs (settings_comparison.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "overlay/cluster/messages.h"
#include "overlay/cluster/options.h"
#include "romano/mqttsn/types.h"

namespace romano::cluster {

using PredefinedTopics = std::map<mqttsn::TopicId, std::string>;

[[nodiscard]] Setting setting(std::string name, std::string value);
[[nodiscard]] std::vector<Setting> agreed_settings(const ClusterOptions& options,
                                                   const PredefinedTopics& predefined);
/// At most so many octets of it, and of UTF-8 whole characters.
[[nodiscard]] std::string cut(std::string text, std::size_t most);
/// Of all of them.
[[nodiscard]] std::uint32_t digest_of(const std::vector<Setting>& settings);
/// What a topic id means to clients that never registered it.
[[nodiscard]] std::uint32_t digest_of(const PredefinedTopics& predefined);

}  // namespace romano::cluster
