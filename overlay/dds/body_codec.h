// Cluster messages as the octets of a sample's body, and back.
//
// Keeps its storage: in the steady state Protobuf's own objects cost no allocation.
#pragma once

#include <google/protobuf/arena.h>

#include <memory>
#include <optional>
#include <string>

#include "overlay/cluster/messages.h"
#include "romano/base/bytes.h"

namespace romano::dds {

class BodyCodec {
public:
    BodyCodec();

    /// The octets live until the next call. Empty when the message is larger than Protobuf takes.
    [[nodiscard]] Bytes encode(const cluster::ClusterMessage& message);
    /// Total: any octets give a message or nothing.
    [[nodiscard]] std::optional<cluster::ClusterMessage> decode(Bytes body);

private:
    std::unique_ptr<char[]> first_block_;  // outlives the arena that uses it
    google::protobuf::Arena arena_;
    std::string octets_;
};

}  // namespace romano::dds
