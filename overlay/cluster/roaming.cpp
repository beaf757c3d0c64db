#include "overlay/cluster/roaming.h"

#include <algorithm>

#include "romano/mqttsn/decode.h"

namespace romano::cluster {
namespace {

constexpr std::size_t fetching_most = 1'000;

/// The client id that a CONNECT or a sleeping client's PINGREQ names.
std::optional<broker::ClientId> named_client(Bytes datagram) {
    const auto frame = mqttsn::decode_frame(datagram);
    if (!frame) return std::nullopt;
    if (frame->type == mqttsn::MsgType::connect) {
        const auto connect = mqttsn::decode_connect(frame->body);
        if (connect && !connect->client_id.empty()) return broker::ClientId{connect->client_id};
    } else if (frame->type == mqttsn::MsgType::pingreq) {
        const auto ping = mqttsn::decode_pingreq(frame->body);
        if (ping && !ping->client_id.empty()) return broker::ClientId{ping->client_id};
    }
    return std::nullopt;
}

}  // namespace

bool Roaming::on_datagram(Effects& effects, const Endpoint& from, Bytes datagram,
                          const Homes& homes, const Membership& membership, const View& view) {
    const auto named = named_client(datagram);
    const auto home = named ? homes.of(*named) : homes.at({from, {}});
    if (!home || fetching_.size() >= fetching_most) return false;
    if (effects.broker.serves(from, datagram)) return false;
    const Peer* peer = membership.find(home->broker);
    if (peer == nullptr || !peer->alive ||
        !std::ranges::binary_search(view.members, peer->beacon.log)) {
        return false;
    }
    fetching_.insert_or_assign(from, Fetching{home->client_id, effects.now});
    effects.peers.push_back({home->broker, SessionRequest{home->client_id}});
    return true;
}

void Roaming::on_handed_over(const broker::ClientId& client) {
    std::erase_if(fetching_, [&](const auto& entry) { return entry.second.client == client; });
}

void Roaming::carry_on(Instant now) {
    std::erase_if(fetching_,
                  [&](const auto& entry) { return now > entry.second.since + 2 * patience_; });
}

}  // namespace romano::cluster
