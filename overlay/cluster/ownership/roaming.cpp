#include "overlay/cluster/ownership/roaming.h"

#include <algorithm>
#include <utility>

#include "romano/mqttsn/decode.h"

namespace romano::cluster {
namespace {

constexpr std::size_t fetching_most = 1'000;
constexpr std::size_t let_go_most = 1'000;

/// What a client said and, behind a forwarder (MQTT-SN 1.2 section 5.5), which of its nodes.
struct Said {
    Bytes message;
    broker::ClientAddress from;
};
Said unwrap(const Endpoint& from, Bytes datagram) {
    const auto frame = mqttsn::decode_frame(datagram);
    if (!frame || frame->type != mqttsn::MsgType::encapsulated) return {datagram, {from, {}}};
    const auto wrapping = mqttsn::decode_encapsulated(*frame);
    if (!wrapping) return {datagram, {from, {}}};
    return {wrapping->message, {from, std::string{as_text(wrapping->wireless_node_id)}}};
}

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

/// Not of a session: searching for gateways (6.1) and publishing without a connection (6.8).
bool is_of_session(Bytes datagram) {
    const auto frame = mqttsn::decode_frame(datagram);
    if (!frame) return false;
    switch (frame->type) {
        case mqttsn::MsgType::advertise:
        case mqttsn::MsgType::searchgw:
        case mqttsn::MsgType::gwinfo:
            return false;
        case mqttsn::MsgType::publish: {
            const auto publish = mqttsn::decode_publish(frame->body);
            return publish && publish->qos != mqttsn::Qos::without_connection;
        }
        default:
            return true;
    }
}

}  // namespace

std::optional<broker::ClientId> Roaming::client_elsewhere(const broker::BrokerCore& own,
                                                          const Way& way, Bytes datagram,
                                                          const Homes& homes,
                                                          const Departures& leaving,
                                                          const Membership& membership) const {
    const Said said = unwrap(way.from, datagram);
    if (!is_of_session(said.message) || own.serves(way.via, way.from, datagram)) {
        return std::nullopt;
    }
    auto client = client_of(way, datagram, own, homes);
    if (!client) return std::nullopt;
    const bool is_known = homes.of(*client) || leaving.all().contains(*client) ||
                          std::ranges::count(let_go_, *client, &LetGo::client) > 0;
    if (!is_known || is_foreign(*client, homes, membership)) return std::nullopt;
    return client;
}

bool Roaming::on_datagram(Effects& effects, const Way& way, Bytes datagram, const Homes& homes,
                          const Departures& leaving, const Membership& membership,
                          const View& view) {
    if (fetching_.size() >= fetching_most) return false;
    auto client = client_elsewhere(effects.broker, way, datagram, homes, leaving, membership);
    if (!client) return false;
    Fetching fetching{.client = *std::move(client),
                      .since = effects.now,
                      .asked = std::nullopt,
                      .asked_at = Instant::min()};
    ask(effects, way, fetching, homes, membership, view);
    fetching_.insert_or_assign(way, std::move(fetching));
    return true;
}

std::optional<broker::ClientId> Roaming::client_of(const Way& way, Bytes datagram,
                                                   const broker::BrokerCore& own,
                                                   const Homes& homes) const {
    const Said said = unwrap(way.from, datagram);
    auto named = named_client(said.message);
    return named ? std::move(named) : client_at({way.via, said.from}, own, homes);
}

std::optional<broker::ClientId> Roaming::client_at(const broker::Origin& place,
                                                   const broker::BrokerCore& own,
                                                   const Homes& homes) const {
    if (auto last = homes.at(place)) return last;
    if (own.has_client_at(place.from)) return std::nullopt;
    auto only = homes.only_one_at(place.from);
    const auto left = std::ranges::find(let_go_, place.from, &LetGo::from);
    if (left == let_go_.end()) return only;
    return only && *only != left->client ? std::nullopt : std::optional{left->client};
}

bool Roaming::is_foreign(const broker::ClientId& client, const Homes& homes,
                         const Membership& membership) const {
    const auto home = homes.of(client);
    const Peer* peer = home ? membership.find(*home) : nullptr;
    return peer != nullptr && peer->beacon.predefined != predefined_;
}

void Roaming::on_let_go(const Effects& effects, const broker::SessionHeader& session) {
    if (let_go_.size() == let_go_most) let_go_.pop_front();
    let_go_.push_back(
        {session.client_id, session.address, effects.now + effects.times.session_waited_for()});
}

void Roaming::on_standstill(Instant now) {
    for (auto& [way, fetching] : fetching_) fetching.since = now;
}

void Roaming::carry_on(Effects& effects, const Logs& logs, const Homes& homes,
                       const Arrivals& arriving, Departures& departures,
                       const Membership& membership, const View& view) {
    while (!let_go_.empty() && let_go_.front().until < effects.now) let_go_.pop_front();
    std::erase_if(fetching_, [&](const auto& entry) {
        const Fetching& fetching = entry.second;
        if (effects.broker.header(fetching.client) != nullptr) return true;
        if (effects.now <= fetching.since + patience_with(effects, fetching, membership, view)) {
            return false;
        }
        if (arriving.holds(fetching.client) || departures.all().contains(fetching.client)) {
            return false;
        }
        if (!fetching.asked) adopt_copy(effects, logs, fetching.client, homes, departures);
        return true;
    });
    for (auto& [way, fetching] : fetching_) ask(effects, way, fetching, homes, membership, view);
}

/// A busy home is late, and to be a stranger would cost its client the session.
Duration Roaming::patience_with(const Effects& effects, const Fetching& fetching,
                                const Membership& membership, const View& view) {
    const Peer* home = fetching.asked ? membership.find(*fetching.asked) : nullptr;
    const bool lives = home != nullptr && home->alive && view.contains(home->beacon.log);
    return lives ? effects.times.living_home_waited_for() : effects.times.session_waited_for();
}

void Roaming::adopt_copy(Effects& effects, const Logs& logs, const broker::ClientId& client,
                         const Homes& homes, Departures& departures) {
    const auto home = homes.of(client);
    if (!home) return;
    for (auto& [id, log] : logs.peers) {
        if (id.broker != *home || log.is_foreign()) continue;
        if (log.session(client) == nullptr) continue;
        if (auto image = log.mirror().image(client)) {
            departures.adopt(effects, logs, *std::move(image));
        }
        log.mark_taken(client);
    }
}

void Roaming::ask(Effects& effects, const Way& way, Fetching& fetching, const Homes& homes,
                  const Membership& membership, const View& view) const {
    const auto home = homes.of(fetching.client);
    if (!home) return;
    const Peer* peer = membership.find(*home);
    if (peer == nullptr || !view.contains(peer->beacon.log)) return;
    // A home that has just stood still listens only: it is asked again. One that cannot answer may
    // hear us, and falls silent.
    const bool is_asked = *home == fetching.asked;
    const Instant again_at = fetching.asked_at + effects.times.session_asked_again_after();
    if ((is_asked || !peer->alive) && effects.now < again_at) return;
    if (peer->alive && !is_asked) {
        fetching.asked = *home;
        fetching.since = effects.now;
    }
    fetching.asked_at = effects.now;
    effects.peers.push_back({*home, SessionRequest{fetching.client, way.via}});
}

}  // namespace romano::cluster
