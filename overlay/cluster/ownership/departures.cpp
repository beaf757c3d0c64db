#include "overlay/cluster/ownership/departures.h"

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include "broker/core/two_copies.h"

namespace romano::cluster {
namespace {

template <typename Key>
void count_out(std::map<Key, std::size_t>& counts, const Key& of) {
    const auto found = counts.find(of);
    if (found != counts.end() && --found->second == 0) counts.erase(found);
}

bool is_foreign(const LogId& home, const PeerLogs& logs) {
    const auto log = logs.find(home);
    return log != logs.end() && log->second.is_foreign();
}

/// Its log has ended, all of it is here, and nothing in it says that the sessions arrived.
bool is_gone(const LogId& home, const PeerLogs& logs, const View& view) {
    if (view.contains(home)) return false;
    const auto log = logs.find(home);
    return log == logs.end() || (log->second.is_frozen() && log->second.has_agreed_end());
}

bool is_late(const Effects& effects, Instant since) {
    return effects.now >= since + effects.times.handover_acknowledged_within();
}

/// The event that says so may have been left out by a snapshot.
bool has_arrived(const Departures::Leaving& leaving, const PeerLogs& logs) {
    const broker::SessionHeader& left = leaving.session.image.header;
    return std::ranges::any_of(logs, [&](const auto& entry) {
        const broker::SessionHeader* other = entry.second.session(left.client_id);
        if (other == nullptr) return false;
        return leaving.epochs > 0 ? other->epoch >= left.epoch : broker::outranks(*other, left);
    });
}

}  // namespace

void Departures::move(Effects& effects, const broker::ClientId& client, const LogId& to,
                      std::uint64_t epochs, const PeerLogs& logs) {
    if (is_foreign(to, logs)) {
        (void)effects.broker.release(client, effects.clients);
        return;
    }
    auto image = effects.broker.move_away(client, to, epochs, effects.clients);
    if (image) put(effects, *std::move(image), to, epochs);
}

void Departures::pass_on(Effects& effects, const Logs& logs, broker::SessionImage image,
                         const LogId& to, const std::optional<LogPosition>& moved) {
    if (is_foreign(to, logs.peers)) return;
    image = caught_up(effects, logs, std::move(image));
    if (auto before = call_off(image.header.client_id)) {
        std::vector<broker::MessagePtr> missed;  // both have all
        before = caught_up(effects, logs, *std::move(before));
        image = broker::settle(*std::move(before), std::move(image), missed).image;
    }
    effects.broker.pass_on(image, to, moved, effects.clients);
    put(effects, std::move(image), to, 1);
}

void Departures::put(Effects& effects, broker::SessionImage image, const LogId& to,
                     std::uint64_t epochs) {
    (void)call_off(image.header.client_id);
    ++speaking_from_[image.header.address.endpoint];
    ++via_[image.header.via];
    ++to_[to];
    if (leaving_.empty()) oldest_ = effects.now;
    const broker::ClientId client = image.header.client_id;
    leaving_.emplace(
        client, Leaving{{std::move(image), to, effects.broker.last_seq()}, epochs, effects.now});
}

Departures::Leaving Departures::take(std::map<broker::ClientId, Leaving>::iterator leaving) {
    Leaving taken = std::move(leaving->second);
    leaving_.erase(leaving);
    const broker::SessionHeader& header = taken.session.image.header;
    count_out(speaking_from_, header.address.endpoint);
    count_out(via_, header.via);
    count_out(to_, taken.session.to);
    return taken;
}

void Departures::on_arrived(const broker::ClientId& client, Seq at) {
    const auto leaving = leaving_.find(client);
    if (leaving != leaving_.end() && leaving->second.session.at == at) (void)take(leaving);
}

std::optional<broker::SessionImage> Departures::call_off(const broker::ClientId& client) {
    const auto leaving = leaving_.find(client);
    if (leaving == leaving_.end()) return std::nullopt;
    return take(leaving).session.image;
}

void Departures::adopt(Effects& effects, const Logs& logs, broker::SessionImage image,
                       const std::optional<LogPosition>& moved) {
    auto ours = call_off(image.header.client_id);
    cluster::adopt(effects, logs, std::move(image), moved, std::move(ours));
}

bool Departures::crosses(const MovedSession& comes, const LogId& from) const {
    const auto leaving = leaving_.find(comes.image.header.client_id);
    if (leaving == leaving_.end() || leaving->second.session.to != from) return false;
    const broker::SessionHeader& ours = leaving->second.session.image.header;
    const broker::SessionHeader& theirs = comes.image.header;
    return broker::outranks(ours, theirs) ||
           (!broker::outranks(theirs, ours) && comes.to.broker > from.broker);
}

bool Departures::has_late_ones(const Effects& effects, const LogId& to) const {
    if (!is_late(effects, oldest_)) return false;
    return std::ranges::any_of(leaving_, [&](const auto& entry) {
        const Leaving& leaving = entry.second;
        return leaving.session.to == to && is_late(effects, leaving.since);
    });
}

void Departures::carry_on(Effects& effects, const Logs& logs, const View& view) {
    is_half_done_ = false;
    std::set<LogId> gone;
    for (const auto& [to, count] : to_) {
        if (is_gone(to, logs.peers, view)) gone.insert(to);
    }
    // They are as many as a home had sessions, and every turn comes here.
    if (gone.empty() && !is_late(effects, oldest_)) return;
    Instant oldest = effects.now;
    std::size_t allowed = sessions_per_turn_;
    for (auto at = leaving_.begin(); at != leaving_.end();) {
        const auto leaving = at++;
        const Instant since = leaving->second.since;
        if (!gone.contains(leaving->second.session.to) && !is_late(effects, since)) {
            oldest = std::min(oldest, since);
            continue;
        }
        if (allowed-- == 0) {
            is_half_done_ = true;
            return;
        }
        Leaving taken = take(leaving);
        if (has_arrived(taken, logs.peers)) continue;
        broker::SessionHeader& header = taken.session.image.header;
        // Where its client began another session meanwhile, the ranks decide.
        if (effects.broker.header(header.client_id) == nullptr) ++header.epoch;
        cluster::adopt(effects, logs, std::move(taken.session.image));
    }
    oldest_ = oldest;
}

}  // namespace romano::cluster
