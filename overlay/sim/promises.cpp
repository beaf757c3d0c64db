#include "overlay/sim/promises.h"

#include <algorithm>
#include <map>
#include <set>
#include <tuple>

#include "romano/mqttsn/topic.h"

namespace romano::sim {

using mqttsn::Qos;

namespace {

using MessageKey = std::pair<std::string, std::uint32_t>;  // publisher, number
using DeliveryKey = std::pair<std::string, MessageKey>;    // subscriber, message

std::string seconds(Instant at) {
    return std::to_string(
               std::chrono::duration_cast<std::chrono::milliseconds>(at.time_since_epoch())
                   .count()) +
           " ms";
}

std::string describe(const Sent& sent) {
    return sent.publisher + "'s message " + std::to_string(sent.number) + " (QoS " +
           std::to_string(static_cast<unsigned>(sent.qos)) + " on " + sent.topic +
           (sent.retain ? ", retained" : "") + ", asked for at " + seconds(sent.at) +
           (sent.acknowledged ? ", acknowledged at " + seconds(*sent.acknowledged) : "") + ")";
}

bool is_parted(const Judgement& judgement, Instant from, Instant until) {
    return std::ranges::any_of(judgement.parted, [&](const Span& span) {
        return span.from <= until && from <= span.until;
    });
}

bool is_parted(const Judgement& judgement, Instant at) {
    return is_parted(judgement, at, at);
}

/// It may have been on its way at any time from the application's wish to the broker's answer.
bool is_parted(const Judgement& judgement, const Sent& sent) {
    return is_parted(judgement, sent.at, sent.acknowledged.value_or(never));
}

/// P3: exactly-once messages come once.
void judge_duplicates(const Ledger& ledger, const Judgement& judgement, Violations& out) {
    std::map<DeliveryKey, Instant> first;
    for (const Reception& r : ledger.receptions) {
        if (r.qos != Qos::exactly_once || r.retain) continue;
        const MessageKey message{r.publisher, r.number};
        const auto [seen, is_new] = first.try_emplace({r.subscriber, message}, r.at);
        if (is_new) continue;
        const auto sent = ledger.sent.find(message);
        if (is_parted(judgement, r.at) || is_parted(judgement, seen->second) ||
            (sent != ledger.sent.end() && is_parted(judgement, sent->second))) {
            continue;
        }
        out.push_back(
            {Promise::exactly_once,
             r.subscriber + " got twice, at " + seconds(seen->second) + " and at " + seconds(r.at) +
                 ": " +
                 (sent == ledger.sent.end() ? "something unknown" : describe(sent->second))});
    }
}

/// P5: what comes for the first time comes in the publisher's order.
void judge_order(const Ledger& ledger, const Judgement& judgement, Violations& out) {
    std::set<DeliveryKey> seen;
    std::map<std::tuple<std::string, std::string, std::string, Qos>, const Sent*> last;
    const auto is_excused = [&](const Sent& sent, Instant at) {
        return is_parted(judgement, sent) || is_parted(judgement, at);
    };
    for (const Reception& r : ledger.receptions) {
        if (r.retain) continue;
        const MessageKey message{r.publisher, r.number};
        const auto found = ledger.sent.find(message);
        if (found == ledger.sent.end()) continue;
        const Sent& sent = found->second;
        if (r.qos != sent.qos) continue;  // granted less
        if (sent.qos == Qos::at_most_once && !judgement.links_keep_order) continue;
        if (!seen.insert({r.subscriber, message}).second || is_excused(sent, r.at)) continue;
        const Sent*& before = last[{r.subscriber, r.publisher, sent.topic, sent.qos}];
        if (before != nullptr && before->number > sent.number) {
            out.push_back({Promise::in_order, r.subscriber + " got at " + seconds(r.at) + " " +
                                                  describe(sent) + " after number " +
                                                  std::to_string(before->number)});
        }
        before = &sent;
    }
}

/// Of messages whose rights changed while they were on their way either may be.
void judge_rights(const Ledger& ledger, const DrawnRights& rights, Violations& out) {
    for (const Reception& r : ledger.receptions) {
        const auto found = ledger.sent.find({r.publisher, r.number});
        if (found == ledger.sent.end()) continue;
        const Sent& sent = found->second;
        if (rights.possibly_reads(r.subscriber, sent) && rights.possibly_publishes(sent)) continue;
        out.push_back({Promise::rights_kept, r.subscriber + " got at " + seconds(r.at) +
                                                 ", against the rights, " + describe(sent)});
    }
    for (const auto& [key, sent] : ledger.sent) {
        if (sent.qos == Qos::at_most_once) continue;
        if (sent.acknowledged && !rights.possibly_publishes(sent)) {
            out.push_back({Promise::rights_kept, "accepted against the rights: " + describe(sent)});
        } else if (sent.refused && rights.surely_publishes(sent)) {
            out.push_back({Promise::rights_kept, "refused against the rights: " + describe(sent)});
        }
    }
}

/// P7: nobody's who lives; and as P3, once.
void judge_needless_wills(const Ledger& ledger, const Judgement& judgement, Violations& out) {
    std::map<std::pair<std::string, std::string>, Instant> first;
    for (const WillSeen& will : ledger.wills) {
        const auto silenced = ledger.silenced.find(will.of);
        if (silenced == ledger.silenced.end() || silenced->second > will.at) {
            out.push_back({Promise::will_once, will.subscriber + " got at " + seconds(will.at) +
                                                   " the will of " + will.of + ", which lives"});
        } else if (will.qos == Qos::exactly_once && !will.retain) {
            const auto [seen, is_new] = first.try_emplace({will.subscriber, will.of}, will.at);
            if (is_new || is_parted(judgement, seen->second) || is_parted(judgement, will.at)) {
                continue;
            }
            out.push_back({Promise::will_once, will.subscriber + " got twice, at " +
                                                   seconds(seen->second) + " and at " +
                                                   seconds(will.at) + ": the will of " + will.of});
        }
    }
}

/// P7: who was subscribed when the robot fell silent has got its will by now.
void judge_missing_wills(const Ledger& ledger, Violations& out) {
    std::set<std::pair<std::string, std::string>> seen;
    for (const WillSeen& will : ledger.wills) seen.emplace(will.subscriber, will.of);
    for (const auto& [robot, at] : ledger.silenced) {
        const auto topic = ledger.will_topics.find(robot);
        if (topic == ledger.will_topics.end()) continue;
        for (const SubscriptionSpan& span : ledger.subscriptions) {
            if (span.until || span.from > at || span.granted == Qos::at_most_once) continue;
            if (!mqttsn::matches(span.filter, topic->second)) continue;
            if (seen.contains({span.subscriber, robot})) continue;
            out.push_back({Promise::will_once, span.subscriber + " never got the will of " + robot +
                                                   ", silent since " + seconds(at)});
        }
    }
}

}  // namespace

std::string to_text(const Violations& violations) {
    constexpr std::size_t most = 10;
    std::string text;
    for (const Violation& violation : violations) {
        if (&violation == &violations.front() + most) {
            return text + "and " + std::to_string(violations.size() - most) + " more\n";
        }
        text += violation.promise == Promise::liveness
                    ? std::string{"liveness"}
                    : "P" + std::to_string(static_cast<unsigned>(violation.promise));
        text += ' ' + violation.what + '\n';
    }
    return text;
}

void judge_safety(const Ledger& ledger, const Judgement& judgement, Violations& out) {
    judge_duplicates(ledger, judgement, out);
    judge_order(ledger, judgement, out);
    judge_needless_wills(ledger, judgement, out);
    if (judgement.rights != nullptr) judge_rights(ledger, *judgement.rights, out);
}

void judge_completeness(const Ledger& ledger, const Judgement& judgement, Violations& out) {
    judge_missing_wills(ledger, out);
    std::set<DeliveryKey> got;
    for (const Reception& r : ledger.receptions) {
        got.insert({r.subscriber, {r.publisher, r.number}});
    }
    for (const auto& [key, sent] : ledger.sent) {
        if (sent.qos == Qos::at_most_once || sent.qos == Qos::without_connection || sent.refused)
            continue;
        if (!sent.acknowledged) {
            if (!ledger.silenced.contains(sent.publisher)) {
                out.push_back({Promise::liveness, "never acknowledged: " + describe(sent)});
            }
            continue;
        }
        for (const SubscriptionSpan& span : ledger.subscriptions) {
            if (span.until || span.from > sent.at || span.granted == Qos::at_most_once) continue;
            if (!mqttsn::matches(span.filter, sent.topic)) continue;
            if (judgement.rights != nullptr &&
                !judgement.rights->surely_reads(span.subscriber, sent)) {
                continue;
            }
            if (got.contains({span.subscriber, key})) continue;
            out.push_back(
                {Promise::nothing_lost, span.subscriber + " never got " + describe(sent)});
        }
    }
}

}  // namespace romano::sim
