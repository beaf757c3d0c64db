// Clients with keys for a bench: the folders that brokers need, and the clients' ends.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "experiments/load/mqttsn_clients.h"
#include "romano/base/endpoint.h"
#include "romano/keys/key_folder.h"

namespace romano::bench {

/// "protected://" and so on, in front of an address; nothing for plain.
[[nodiscard]] const char* scheme_of(Endpoint::Packets packets);

class Fleet {
public:
    /// In place of what is in `folder`.
    Fleet(const std::filesystem::path& folder, const std::vector<std::string>& brokers,
          std::uint32_t clients);

    /// What a broker is to be given, --keys and --rights: all may publish and read everything.
    [[nodiscard]] std::vector<std::string> broker_arguments(const std::string& broker) const;
    [[nodiscard]] std::filesystem::path key_file(std::uint32_t client) const;
    /// With its key in memory: no file is written while something is measured.
    [[nodiscard]] experiments::KeyedClient client(std::uint32_t number, Endpoint::Packets packets,
                                                  keys::ClientSpeech::Put put) const;

private:
    std::filesystem::path folder_;
    keys::KeyFolder keys_;
    keys::ClientKeys table_;
};

}  // namespace romano::bench
