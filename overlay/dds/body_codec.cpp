#include "overlay/dds/body_codec.h"

#include <limits>

#include "overlay/dds/cluster_message_proto.h"

namespace romano::dds {
namespace {

constexpr std::size_t block_octets = 256UL * 1024;

google::protobuf::ArenaOptions with_first_block(char* block) {
    google::protobuf::ArenaOptions options;
    options.initial_block = block;
    options.initial_block_size = block_octets;
    return options;
}

}  // namespace

BodyCodec::BodyCodec()
    : first_block_(std::make_unique_for_overwrite<char[]>(block_octets)),
      arena_(with_first_block(first_block_.get())) {}

Bytes BodyCodec::encode(const cluster::ClusterMessage& message) {
    arena_.Reset();
    auto* whole = google::protobuf::Arena::CreateMessage<overlay::proto::ClusterMessage>(&arena_);
    to_proto(message, *whole);
    whole->set_protocol(protocol);
    if (std::holds_alternative<cluster::Heartbeat>(message)) {
        whole->set_program_version(ROMANO_VERSION);
    }
    octets_.clear();
    if (!whole->SerializeToString(&octets_)) octets_.clear();
    return as_octets(octets_);
}

overlay::proto::ClusterMessage* BodyCodec::parse(Bytes body) {
    arena_.Reset();
    auto* whole = google::protobuf::Arena::CreateMessage<overlay::proto::ClusterMessage>(&arena_);
    constexpr std::size_t most = std::numeric_limits<int>::max();
    const bool is_whole =
        body.size() <= most && whole->ParseFromArray(body.data(), static_cast<int>(body.size()));
    return is_whole ? whole : nullptr;
}

std::optional<cluster::ClusterMessage> BodyCodec::decode(Bytes body) {
    const auto* whole = parse(body);
    if (whole == nullptr || whole->protocol() != protocol) return std::nullopt;
    return from_proto(*whole);
}

std::optional<std::string> BodyCodec::version_of_other_protocol(Bytes body) {
    const auto* whole = parse(body);
    if (whole == nullptr || whole->protocol() == protocol) return std::nullopt;
    const bool has_neither = whole->protocol() == 0 && whole->program_version().empty();
    return has_neither ? "0" : whole->program_version();
}

}  // namespace romano::dds
