// A world whose robots and brokers protect their packets (romano/protection): its keys, and all
// nonces that were ever used in it, whoever used them. None may be used twice.
#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "broker/protection/protected_clients.h"
#include "romano/base/bytes.h"
#include "romano/protection/keys.h"
#include "romano/protection/packet.h"

namespace romano::sim {

class SealedPackets {
public:
    enum class Way : std::uint8_t { to_broker, to_robot };

    [[nodiscard]] static protection::RobotKey key_of(std::string_view robot);
    /// Of robots that are called robot0, robot1, ..., and of each that starts again under a new
    /// name.
    [[nodiscard]] static std::vector<broker::ProtectedClient> clients(std::size_t robots);

    /// As it leaves, under that robot's key.
    void on_sealed(const std::string& robot, Way way, Bytes packet);

    [[nodiscard]] std::size_t count() const { return used_.size(); }
    [[nodiscard]] std::uint64_t repeated() const { return repeated_; }

private:
    std::set<std::tuple<std::string, Way, protection::Nonce>> used_;
    std::uint64_t repeated_ = 0;
};

}  // namespace romano::sim
