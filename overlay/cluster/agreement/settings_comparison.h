// What all brokers of a cluster must be told alike, as people wrote it: compared by digest. Where
// it differs, people are told by name, at both brokers, once.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "overlay/cluster/effects.h"
#include "overlay/cluster/messages.h"
#include "overlay/cluster/options.h"
#include "romano/mqttsn/types.h"

namespace romano::cluster {

using PredefinedTopics = std::map<mqttsn::TopicId, std::string>;

[[nodiscard]] std::vector<Setting> agreed_settings(const ClusterOptions& options,
                                                   const PredefinedTopics& predefined);
/// What a topic id means to clients that never registered it.
[[nodiscard]] std::uint32_t digest_of(const PredefinedTopics& predefined);

struct Difference {
    std::string setting;
    std::string ours;
    std::string theirs;
};

class SettingsComparison {
public:
    SettingsComparison(std::string name, std::vector<Setting> own);

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
        bool is_compared = false;
    };

    std::string name_;
    std::vector<Setting> own_;
    std::uint32_t digest_;
    std::map<BrokerId, Other> others_;
};

}  // namespace romano::cluster
