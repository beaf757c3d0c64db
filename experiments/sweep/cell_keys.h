// The keys of a cell whose clients have some: a fleet's folder, gone with the cell. It lies in
// memory, for what each client does on a machine of its own would wait here for one disk.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "experiments/sweep/cell.h"
#include "experiments/sweep/sweep_file.h"
#include "romano/keys/client_packets.h"
#include "romano/keys/key_folder.h"

namespace romano::experiments {

class CellKeys {
public:
    /// Of its brokers, its robots, and who watches and probes. Throws RunFailed.
    CellKeys(const SweepSettings& settings, const Cell& cell);
    ~CellKeys();
    CellKeys(const CellKeys&) = delete;
    CellKeys& operator=(const CellKeys&) = delete;

    /// What that broker is given beside its address: its folder, and rights by which robots publish
    /// and read whatever the sweep has them publish and read.
    [[nodiscard]] std::vector<std::string> broker_arguments(const std::string& broker) const;
    /// With the client's own key. Throws RunFailed.
    [[nodiscard]] std::shared_ptr<keys::ClientPackets> packets_of(
        const std::string& client_id) const;

private:
    keys::Speech speech_;
    std::filesystem::path folder_;
    keys::KeyFolder keys_;
    std::vector<std::string> watchers_;
};

}  // namespace romano::experiments
