// Cluster messages as the octets of a sample's body, and back.
//
// Keeps its storage: in the steady state Protobuf's own objects cost no allocation.
#pragma once

#include <google/protobuf/arena.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "overlay/cluster/messages.h"
#include "romano/base/bytes.h"

namespace romano::overlay::proto {
class ClusterMessage;
}

namespace romano::dds {

class BodyCodec {
public:
    BodyCodec();

    /// The octets live until the next call. Empty when the message is larger than Protobuf takes.
    [[nodiscard]] Bytes encode(const cluster::ClusterMessage& message);
    /// Total: any octets give a message or nothing. Nothing of another protocol, too.
    [[nodiscard]] std::optional<cluster::ClusterMessage> decode(Bytes body);
    /// Of the program that said this in another protocol: "0" when it comes from before there were
    /// versions; else it may be empty. Nothing when it is this protocol, or none.
    [[nodiscard]] std::optional<std::string> version_of_other_protocol(Bytes body);

    /// What brokers of this build speak, and require of each other.
    static constexpr std::uint32_t protocol = 10;

private:
    /// In the arena; null when the octets are no such message.
    [[nodiscard]] overlay::proto::ClusterMessage* parse(Bytes body);

    std::unique_ptr<char[]> first_block_;  // outlives the arena that uses it
    google::protobuf::Arena arena_;
    std::string octets_;
};

}  // namespace romano::dds
