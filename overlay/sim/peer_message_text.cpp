#include "overlay/sim/peer_message_text.h"

#include <variant>

#include "overlay/sim/trace.h"
#include "romano/base/bytes.h"

namespace romano::sim {
namespace {

using namespace broker;
using namespace cluster;

template <typename Number>
std::string number(Number value) {
    return std::to_string(static_cast<std::uint64_t>(value));
}

/// Brokers' ids are hashes and incarnations are times: the last digits tell them apart.
template <typename Id>
std::string short_id(Id id) {
    return std::to_string(static_cast<std::uint64_t>(id) % 1000);
}
std::string text(const LogId& log) {
    return short_id(log.broker) + '/' + short_id(log.incarnation / 1'000'000);
}
std::string text(const LogPosition& position) {
    return text(position.log) + ':' + number(position.seq);
}
std::string text(const std::vector<LogPosition>& positions) {
    std::string all;
    for (const LogPosition& position : positions) all += ' ' + text(position);
    return all;
}
std::string text(const MessagePtr& message) {
    if (!message) return "?";
    return text(message->position) + ' ' + message->topic + " \"" +
           std::string{as_text(message->payload)}.substr(0, 12) + '"';
}
std::string text(const ViewNumber& number_of_view) {
    return number(number_of_view.term) + '.' + number(number_of_view.count);
}
std::string text(const View& view) {
    std::string all = text(view.number) + " of";
    for (const LogId& member : view.members) all += ' ' + text(member);
    return all;
}
std::string text(const SessionHeader& header) {
    return header.client_id + " epoch " + number(header.epoch) +
           (header.provisional ? " provisional" : "") + " via " + to_text(header.via);
}
std::string text(const SessionImage& image) {
    std::string all = text(image.header) + " worked" + text(image.worked_through);
    for (const broker::Delivery& delivery : image.deliveries) {
        all += " delivery " + text(delivery.position) + " stage " + number(delivery.stage);
    }
    for (const mqttsn::MsgId id : image.unreleased) all += " unreleased " + number(id);
    return all;
}
std::string text(const std::vector<SessionImage>& sessions) {
    std::string all;
    for (const SessionImage& image : sessions) all += " [" + text(image) + ']';
    return all;
}
std::string text(const std::vector<Route>& routes) {
    std::string all;
    for (const Route& route : routes) all += ' ' + route.client_id;
    return all;
}

std::string event(const SessionPut& e) {
    return "put [" + text(e.image) + ']' + (e.adopted ? " of " + text(*e.adopted) : "");
}
std::string event(const SessionMoved& e) {
    return "moved [" + text(e.header) + "] to " + text(e.to);
}
std::string event(const Sealed& e) {
    return "sealed " + to_text(e.address) + " to " + text(e.to);
}
std::string event(const SessionChanged& e) {
    return "changed [" + text(e.header) + ']';
}
std::string event(const SessionErased& e) {
    return "erased " + e.client_id;
}
std::string event(const WillChanged& e) {
    return "will of " + e.client_id;
}
std::string event(const Subscribed& e) {
    return "subscribed " + e.client_id + ' ' + e.subscription.filter;
}
std::string event(const Unsubscribed& e) {
    return "unsubscribed " + e.client_id + ' ' + e.filter;
}
std::string event(const TopicBound& e) {
    return "topic " + e.client_id + ' ' + e.binding.name;
}
std::string event(const Published& e) {
    return "published " + text(e.message) + " for" + text(e.routes) +
           (e.will_of.empty() ? "" : " will of lost " + e.will_of);
}
std::string event(const Routed& e) {
    return "routed " + text(e.message) + " for" + text(e.routes);
}
std::string event(const Cursor& e) {
    std::string all = "cursor";
    for (const LogPosition& through : e.through) all += ' ' + text(through);
    return all;
}
std::string event(const DeliveryStarted& e) {
    return "started " + e.client_id + ' ' + text(e.message) + " #" + number(e.msg_id);
}
std::string event(const DeliveryReleased& e) {
    return "released " + e.client_id + ' ' + text(e.message);
}
std::string event(const DeliveryEnded& e) {
    return "ended " + e.client_id + ' ' + text(e.message);
}
std::string event(const PublishReleased& e) {
    return "unreleased " + e.client_id + " #" + number(e.msg_id);
}
std::string text(const std::vector<LogEventPtr>& events) {
    std::string all;
    for (const LogEventPtr& e : events) {
        all += " | " + std::visit([](const auto& of) { return event(of); }, *e);
    }
    return all;
}

std::string line(const Heartbeat& m) {
    std::string all = "Heartbeat " + number(m.tick) + " of " + text(m.log) + ':' +
                      number(m.last_seq) + " view " + text(m.view) +
                      (m.promised == m.view ? "" : " promised " + text(m.promised)) + " follows " +
                      (m.claim.leader ? short_id(*m.claim.leader) : "nobody") + " term " +
                      number(m.claim.term) + " hears members";
    for (const std::uint8_t places : m.hears_members) all += ' ' + number(places);
    all += " and";
    for (const BrokerId id : m.hears_others) all += ' ' + short_id(id);
    all += " holds";
    for (const auto& [member, through] : m.held) {
        all += ' ' + number(member) + ':' + number(through);
    }
    return all + text(m.held_others) + (m.leaving ? " leaving" : "");
}
std::string line(const SecuredTold& m) {
    std::string all = "SecuredTold";
    for (const auto& client : m.packets) {
        all += ' ' + number(client.sender) + ':' + number(client.floor);
    }
    for (const auto& association : m.associations) all += ' ' + association.client;
    for (const auto& progress : m.progress) {
        all += ' ' + number(progress.id) + ':' + number(progress.floor);
    }
    return all;
}
std::string line(const Particulars& told) {
    if (told.wanted) return "Particulars wanted";
    const Beacon& m = told.beacon;
    std::string all = "Particulars of " + text(m.log) + ':' + number(m.last_seq) + " view " +
                      text(m.view.number) + " follows " +
                      (m.claim.leader ? short_id(*m.claim.leader) : "nobody") + " term " +
                      number(m.claim.term) + " hears";
    for (const BrokerId id : m.hears) all += ' ' + short_id(id);
    all += " applied" + text(m.applied) + " ended" + text(m.ended) + " serving";
    for (const Endpoint& address : m.serving) all += ' ' + to_text(address);
    all += " binding";
    for (const Endpoint& address : m.binding) all += ' ' + to_text(address);
    return all + (m.leaving ? " leaving" : "");
}
std::string line(const LogBatch& m) {
    return "LogBatch " + text(LogPosition{m.log, m.first_seq}) + text(m.events);
}
std::string line(const LogAck& m) {
    return "LogAck " + text(m.through);
}
std::string line(const ForwardBatch& m) {
    std::string all = "ForwardBatch";
    for (const MessagePtr& message : m.messages) all += ' ' + text(message);
    return all;
}
std::string line(const ElectionMessage&) {
    return "ElectionMessage";
}
std::string line(const ViewProposal& m) {
    std::string all = "ViewProposal " + text(m.view) + " removed";
    for (const LogId& log : m.removed) all += ' ' + text(log);
    return all;
}
std::string line(const ViewHoldings& m) {
    std::string all = "ViewHoldings " + text(m.number) + text(m.holds);
    for (const LogId& log : m.outdated) all += " outdated " + text(log);
    for (const LeftAddress& left : m.addresses) {
        all += " left " + text(left.log) + ' ' + to_text(left.address);
    }
    return all;
}
std::string line(const ViewAnnouncement& m) {
    std::string all = "ViewAnnouncement " + text(m.view) + " ends" + text(m.ends);
    for (const Assignment& a : m.assignments) {
        all += " assigns " + text(a.end) + ' ' + to_text(a.address) + " to " + short_id(a.heir);
    }
    return all;
}
std::string line(const Fetch& m) {
    return "Fetch after " + text(m.after) + " for " + short_id(m.to);
}
std::string line(const SnapshotPart& m) {
    std::string all = "SnapshotPart " + text(m.as_of) + text(m.sessions) + " gone " +
                      std::to_string(m.gone.size()) + " moved " + std::to_string(m.moved.size()) +
                      " cursors" + text(m.cursors) + " publishes";
    for (const MessagePtr& message : m.publishes) all += ' ' + text(message);
    return all;
}
std::string line(const SessionRequest& m) {
    return "SessionRequest " + m.client_id + " at " + to_text(m.at);
}
std::string line(const Pulse& m) {
    return "Pulse after beacon " + std::to_string(m.tick);
}
}  // namespace

std::string to_text(const ClusterMessage& message) {
    return std::visit([](const auto& m) { return line(m); }, message);
}

}  // namespace romano::sim
