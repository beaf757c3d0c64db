#include "overlay/cluster/agreement/heartbeat.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "romano/base/bytes.h"
#include "romano/base/fnv1a.h"

namespace romano::cluster {
namespace {

using Digest = Fnv1a<std::uint32_t>;

void add(Digest& digest, const Endpoint& endpoint) {
    digest.add(static_cast<std::uint64_t>(endpoint.family));
    for (const std::uint8_t octet : endpoint.address) digest.add(octet);
    digest.add(std::uint64_t{endpoint.port} << 32U | endpoint.scope);
    digest.add(static_cast<std::uint8_t>(endpoint.packets));
}

void add(Digest& digest, const std::vector<Endpoint>& endpoints) {
    digest.add(std::uint64_t{endpoints.size()});
    for (const Endpoint& endpoint : endpoints) add(digest, endpoint);
}

/// Its place among the members.
std::optional<std::uint32_t> place_of(const LogId& log, const View& view) {
    const auto found = std::ranges::lower_bound(view.members, log);
    if (found == view.members.end() || *found != log) return std::nullopt;
    return static_cast<std::uint32_t>(found - view.members.begin());
}

std::optional<std::size_t> place_of(BrokerId broker, const View& view) {
    const auto found = std::ranges::lower_bound(view.members, broker, {}, &LogId::broker);
    if (found == view.members.end() || found->broker != broker) return std::nullopt;
    return static_cast<std::size_t>(found - view.members.begin());
}

/// The own copy of a view that a peer has, too: it is looked at with each heartbeat, and so nearer
/// than a hundred copies of the same.
const View& nearest(const View& own, const View& peers) {
    const bool is_same = own.number == peers.number && own.members.size() == peers.members.size();
    return is_same ? own : peers;
}

constexpr std::uint64_t ticks_told_apart = 127;  // by an echo's octet
constexpr std::uint8_t vouches = 0x80;           // in the same octet

/// Of the members of one view, and of others: whom it hears, and for whom it vouches.
bool says_the_same_of_others(const Heartbeat& a, const Heartbeat& b) {
    const auto vouch_alike = [](std::uint8_t one, std::uint8_t other) {
        return ((one ^ other) & vouches) == 0;
    };
    return a.hears_members == b.hears_members && a.hears_others == b.hears_others &&
           std::ranges::equal(a.echoes, b.echoes, vouch_alike);
}

/// `held` is in the order of logs. The log stands at that place, or one before, where all that are
/// held are members' but one, the holder's own.
void set_held(std::vector<LogPosition>& held, const LogPosition& position, std::size_t place = 0) {
    for (std::size_t at = place == 0 ? 0 : place - 1; at <= place && at < held.size(); ++at) {
        if (held[at].log != position.log) continue;
        held[at].seq = position.seq;
        return;
    }
    const auto found = std::ranges::lower_bound(held, position.log, {}, &LogPosition::log);
    if (found != held.end() && found->log == position.log) {
        found->seq = position.seq;
    } else if (held.size() < HeartbeatReader::logs_most) {
        held.insert(found, position);
    }
}

}  // namespace

std::uint32_t digest_of_particulars(const Beacon& beacon) {
    Digest digest;
    digest.add(std::uint64_t{beacon.name.size()});
    digest.add(std::string_view{beacon.name});
    add(digest, beacon.home_addresses);
    add(digest, beacon.serving);
    add(digest, beacon.binding);
    add(digest, beacon.link.endpoint);
    digest.add(beacon.link.process);
    digest.add(as_text(beacon.link.secret));
    digest.add(std::uint64_t{beacon.cannot_take});
    digest.add(std::uint64_t{beacon.settings});
    digest.add(std::uint64_t{beacon.predefined});
    return digest.value();
}

// --- the writer

Heartbeat HeartbeatWriter::write(const Beacon& beacon) {
    Heartbeat out{.log = beacon.log,
                  .tick = beacon.tick,
                  .last_seq = beacon.last_seq,
                  .particulars = digest_of_particulars(beacon),
                  .view = beacon.view.number,
                  .promised = beacon.promised,
                  .claim = beacon.claim,
                  .members = static_cast<std::uint32_t>(beacon.view.members.size()),
                  .logs_held = static_cast<std::uint32_t>(beacon.applied.size()),
                  .sessions = beacon.sessions,
                  .connected = beacon.connected,
                  .leaving = beacon.leaving};
    if (beacon.tick % usage_told_every == 0) out.usage = beacon.usage;
    const std::uint32_t before = std::exchange(particulars_, out.particulars);
    has_news_ = before != 0 && before != out.particulars;

    out.hears_members.resize((beacon.view.members.size() + 7) / 8);
    for (const BrokerId id : beacon.hears) {
        if (const auto place = place_of(id, beacon.view)) {
            out.hears_members[*place / 8] |= static_cast<std::uint8_t>(1U << (*place % 8));
        } else {
            out.hears_others.push_back(id);
        }
    }
    out.echoes.resize(beacon.view.members.size());
    for (const Echo& echo : beacon.echoes) {
        if (const auto place = place_of(echo.of, beacon.view)) {
            out.echoes[*place] = static_cast<std::uint8_t>(1 + echo.tick % ticks_told_apart);
        }
    }
    for (const BrokerId id : beacon.vouched) {
        if (const auto place = place_of(id, beacon.view)) out.echoes[*place] |= vouches;
    }

    const auto say = [&](const LogPosition& position) {
        if (const auto place = place_of(position.log, beacon.view)) {
            out.held.push_back({*place, position.seq});
        } else {
            out.held_others.push_back(position);
        }
    };
    erase_if(held_, [&](const auto& entry) { return !beacon.held_of(entry.first); });
    std::vector<LogPosition> unchanged;
    for (const LogPosition& position : beacon.applied) {
        const auto [at, is_new] = held_.try_emplace(position.log, Said{position.seq, beacon.tick});
        if (at->second.through != position.seq) at->second = {position.seq, beacon.tick};
        if (beacon.tick < at->second.changed_at + said_in) {
            say(position);
        } else {
            unchanged.push_back(position);
        }
    }
    const auto next = std::ranges::find_if(unchanged, [&](const LogPosition& position) {
        return repeated_last_ && position.log > *repeated_last_;
    });
    std::ranges::rotate(unchanged, next);
    if (unchanged.size() > repeated) unchanged.resize(repeated);
    for (const LogPosition& position : unchanged) say(position);
    if (!unchanged.empty()) repeated_last_ = unchanged.back().log;
    return out;
}

// --- the reader

bool HeartbeatReader::Peer::lacks_something() const {
    const std::uint64_t all_are_said_in =
        heartbeat.logs_held / HeartbeatWriter::repeated + 2 * HeartbeatWriter::said_in;
    return !is_known || particulars != heartbeat.particulars || lacks_view || lacks_echo ||
           (counts_differ_since != 0 && heartbeat.tick > counts_differ_since + all_are_said_in);
}

HeartbeatReader::Peer* HeartbeatReader::find_or_add(const LogId& log) {
    if (peers_.size() >= peers_most && !peers_.contains(log.broker)) peers_.clear();
    Peer& peer = peers_[log.broker];
    if (log.incarnation < peer.heartbeat.log.incarnation) return nullptr;
    if (log != peer.heartbeat.log) peer = Peer{};
    peer.heartbeat.log = log;
    return &peer;
}

bool HeartbeatReader::read(const Heartbeat& heartbeat, Beacon* last, const View& own_view,
                           std::uint64_t own_tick) {
    Peer* peer = find_or_add(heartbeat.log);
    if (peer == nullptr || heartbeat.tick <= peer->heartbeat.tick) return false;
    peer->is_joined = peer->is_joined && says_the_same_of_others(heartbeat, peer->heartbeat);
    peer->heartbeat = heartbeat;
    peer->is_known = last != nullptr;
    if (last == nullptr) {
        peer->is_joined = false;
        return false;
    }
    join(*peer, *last, own_view);
    join_echo(*peer, *last, own_view, own_tick);
    return true;
}

/// The oldest tick that it may be: of two echoes the later one is of no older tick. What is far
/// behind our own one went round while nothing was heard: the particulars name the whole tick.
void HeartbeatReader::join_echo(Peer& peer, Beacon& beacon, const View& own_view,
                                std::uint64_t own_tick) const {
    beacon.echoes.clear();
    peer.lacks_echo = false;
    if (peer.lacks_view) {
        beacon.vouched.clear();
        return;
    }
    const View& view = nearest(own_view, beacon.view);
    const auto& octets = peer.heartbeat.echoes;
    const auto place = place_of(self_, view);
    if (!place) return;
    const std::uint8_t said = *place < octets.size() ? octets[*place] & ~vouches : 0;
    if (said == 0) return;
    if (!peer.echo || peer.echo->of != view.members[*place]) {
        peer.lacks_echo = true;
        return;
    }
    const std::uint64_t told = said - 1U;
    std::uint64_t& tick = peer.echo->tick;
    tick += (told + ticks_told_apart - tick % ticks_told_apart) % ticks_told_apart;
    peer.lacks_echo = tick + ticks_told_apart / 2 < own_tick;
    beacon.echoes.push_back(*peer.echo);
}

std::optional<Beacon> HeartbeatReader::read(const Particulars& told, const Beacon* last,
                                            const View& own_view) {
    const auto found = peers_.find(told.beacon.log.broker);
    if (found == peers_.end() || found->second.heartbeat.log != told.beacon.log) {
        return std::nullopt;
    }
    Peer& peer = found->second;
    Beacon joined = told.beacon;
    std::ranges::sort(joined.applied);
    std::ranges::sort(joined.hears);
    if (last != nullptr && told.beacon.tick <= last->tick) {
        // Heartbeats that came since tell more of the logs that are held.
        for (LogPosition& position : joined.applied) {
            position.seq = std::max(position.seq, last->applied_through(position.log));
        }
    }
    std::erase_if(joined.echoes, [this](const Echo& echo) { return echo.of.broker != self_; });
    if (!joined.echoes.empty()) {
        const Echo& told_echo = joined.echoes.front();
        const bool is_older =
            peer.echo && peer.echo->of == told_echo.of && peer.echo->tick > told_echo.tick;
        if (!is_older) peer.echo = told_echo;
        peer.lacks_echo = false;
    }
    peer.is_known = true;
    peer.is_joined = false;
    peer.particulars = digest_of_particulars(joined);
    peer.counts_differ_since = 0;
    peer.asked_at.reset();
    if (told.beacon.tick < peer.heartbeat.tick) {
        join(peer, joined, own_view);
        joined.vouched = told.beacon.vouched;  // as old as its echo
        peer.is_joined = false;
        return joined;
    }
    peer.heartbeat.tick = told.beacon.tick;
    peer.heartbeat.view = told.beacon.view.number;
    peer.heartbeat.promised = told.beacon.promised;
    peer.heartbeat.members = static_cast<std::uint32_t>(told.beacon.view.members.size());
    peer.heartbeat.particulars = peer.particulars;
    peer.lacks_view = false;
    return joined;
}

void HeartbeatReader::join(Peer& peer, Beacon& beacon, const View& own_view) const {
    const Heartbeat& said = peer.heartbeat;
    beacon.tick = said.tick;
    beacon.last_seq = said.last_seq;
    beacon.promised = said.promised;
    beacon.claim = said.claim;
    beacon.sessions = said.sessions;
    beacon.connected = said.connected;
    if (said.usage.transport_octets_sent != 0) beacon.usage = said.usage;
    beacon.leaving = said.leaving;
    join_view(peer, beacon, own_view);
    for (const LogPosition& position : said.held_others) set_held(beacon.applied, position);
    if (beacon.applied.size() == said.logs_held) {
        peer.counts_differ_since = 0;
    } else if (peer.counts_differ_since == 0) {
        peer.counts_differ_since = said.tick;
    }
}

/// In a view that is not known here the sender hears whom it heard before, but us it may name.
void HeartbeatReader::join_view(Peer& peer, Beacon& beacon, const View& own_view) const {
    const Heartbeat& said = peer.heartbeat;
    const auto is_said = [&](const View& view) {
        return view.number == said.view && view.members.size() == said.members;
    };
    if (!is_said(beacon.view)) {
        peer.is_joined = false;
        if (said.members == 0) beacon.view = {.number = said.view, .members = {}};
        if (is_said(own_view)) beacon.view = own_view;
    }
    peer.lacks_view = !is_said(beacon.view);
    if (peer.lacks_view) {
        if (std::ranges::count(said.hears_others, self_) != 0 && !beacon.hears_from(self_)) {
            beacon.hears.insert(std::ranges::lower_bound(beacon.hears, self_), self_);
        }
        return;
    }
    if (!std::exchange(peer.is_joined, true)) join_hears(peer, beacon);
    const auto& members = nearest(own_view, beacon.view).members;
    for (const auto& [member, through] : said.held) {
        if (member < members.size()) set_held(beacon.applied, {members[member], through}, member);
    }
}

/// Whom it hears, and for whom it vouches.
void HeartbeatReader::join_hears(Peer& peer, Beacon& beacon) {
    const Heartbeat& said = peer.heartbeat;
    const auto& members = beacon.view.members;
    beacon.hears.clear();
    beacon.vouched.clear();
    for (std::size_t place = 0; place < members.size(); ++place) {
        const std::size_t octet = place / 8;
        if (octet < said.hears_members.size() && (said.hears_members[octet] >> (place % 8U) & 1U)) {
            beacon.hears.push_back(members[place].broker);
        }
        if (place < said.echoes.size() && (said.echoes[place] & vouches) != 0) {
            beacon.vouched.push_back(members[place].broker);
        }
    }
    beacon.hears.insert(beacon.hears.end(), said.hears_others.begin(), said.hears_others.end());
    std::ranges::sort(beacon.hears);
}

bool HeartbeatReader::is_complete(BrokerId broker) const {
    const auto found = peers_.find(broker);
    return found != peers_.end() && !found->second.lacks_something();
}

bool HeartbeatReader::must_ask(Instant now, Duration again_after, BrokerId broker) {
    const auto found = peers_.find(broker);
    if (found == peers_.end() || !found->second.lacks_something()) return false;
    std::optional<Instant>& asked_at = found->second.asked_at;
    if (asked_at && now < *asked_at + again_after) return false;
    asked_at = now;
    return true;
}

}  // namespace romano::cluster
