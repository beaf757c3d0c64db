#include "overlay/cluster/replication/peer_sessions.h"

namespace romano::cluster {

void PeerSessions::on_event(Instant now, const broker::Mirror& sessions,
                            const broker::LogEvent& event, std::size_t many) {
    if (follow(sessions.log())) interest_.on_event(sessions, event);
    homes_.on_event(sessions.log().broker, event);
    slow_.on_event(now, sessions, event, many);
}

void PeerSessions::on_late_event(const LogId& log) {
    if (follow(log)) unfollow(log);
}

/// I7: a client that roams is fetched from its home in the view, and not from one beyond it.
void PeerSessions::unfollow(const LogId& log) {
    if (followed_.erase(log.broker) == 0) return;
    homes_.on_end(log.broker);
    ended_.insert_or_assign(log.broker, log);
}

void PeerSessions::on_first_snapshot(const SnapshotPart& part,
                                     const std::vector<broker::SessionImage>& replaced) {
    const LogId& log = part.as_of.log;
    if (part.part == 0) reset(log, broker::Mirror(log));
    for (const auto& image : replaced) interest_.remove(log.broker, image);
    for (const auto& image : part.sessions) {
        interest_.add(log.broker, image);
        homes_.put(log.broker, image.header);
    }
    for (const auto& client : part.gone) homes_.forget(log.broker, client);
}

void PeerSessions::reset(const LogId& log, const broker::Mirror& sessions) {
    const auto former = followed_.find(log.broker);
    if (former != followed_.end() && former->second != log) unfollow(LogId{former->second});
    const auto ended = ended_.find(log.broker);
    if (ended != ended_.end() && ended->second == log)
        homes_.forget_ended(log.broker);  // it goes on
    interest_.reset(sessions);
    homes_.reset(log.broker, sessions);
    slow_.forget(log.broker);
    followed_.insert_or_assign(log.broker, log);
}

bool PeerSessions::follow(const LogId& log) const {
    const auto followed = followed_.find(log.broker);
    return followed != followed_.end() && followed->second == log;
}

void PeerSessions::on_end(const LogId& log) {
    if (followed_.contains(log.broker) && !follow(log)) return;
    interest_.forget(log.broker);
    unfollow(log);
}

void PeerSessions::forget(const LogId& log) {
    on_end(log);
    const bool ended_last =
        std::erase_if(ended_, [&](const auto& entry) { return entry.second == log; }) != 0;
    if (followed_.contains(log.broker)) {
        if (ended_last) homes_.forget_ended(log.broker);
        return;
    }
    homes_.forget(log.broker);
    slow_.forget(log.broker);
}

void PeerSessions::on_own_session(const broker::ClientId& client, const PeerLogs& logs) {
    slow_.forget(client);
    on_living_home(client, logs);
}

void PeerSessions::on_living_home(const broker::ClientId& client, const PeerLogs& logs) {
    for (const auto& [id, log] : logs) {
        if (followed_.contains(id.broker)) {
            homes_.forget_ended(id.broker, client);
        } else {
            homes_.forget(id.broker, client);
        }
    }
}

}  // namespace romano::cluster
