#include "broker/core/cell.h"

#include <algorithm>
#include <chrono>
#include <iterator>

#include "romano/mqttsn/cell.h"
#include "romano/mqttsn/codec.h"

namespace romano::broker {

using mqttsn::Qos;

namespace {

/// One listener alone is better served by a unicast, which a radio acknowledges.
constexpr std::size_t fewest_members = 2;

/// An answer takes so long on a shared channel: a PUBACK in an IEEE 802.15.4 frame of 28 octets
/// takes 1 ms, its acknowledgement and the wait for a free channel about twice that.
constexpr std::chrono::milliseconds answer_time{5};

/// An answer may come so much later than the spread says, before a unicast follows.
constexpr std::chrono::milliseconds patience{1000};

unsigned answer_steps_for(std::size_t members) {
    const auto steps =
        (members * answer_time + mqttsn::cell_answer_step - std::chrono::milliseconds{1}) /
        mqttsn::cell_answer_step;
    return static_cast<unsigned>(std::min<std::int64_t>(steps, 255));
}

void append_be16(std::vector<std::uint8_t>& octets, std::uint16_t number) {
    octets.push_back(static_cast<std::uint8_t>(number >> 8U));
    octets.push_back(static_cast<std::uint8_t>(number));
}

std::uint16_t number_of(const Session& session) {
    return mqttsn::listener_number(session.header.client_id);
}

}  // namespace

bool can_listen(const Session& session) {
    const SessionHeader& header = session.header;
    const bool is_named_by_its_address = header.client_id.starts_with('@');
    return header.via.packets == Endpoint::Packets::plain &&
           header.address.wireless_node_id.empty() && !is_named_by_its_address;
}

bool Cell::takes(std::string_view topic, Qos qos) const {
    return tables_.options.cell_group.family != Endpoint::Family::none &&
           qos <= Qos::at_least_once && topic.size() <= mqttsn::most_cell_name;
}

void Cell::deliver(std::string_view topic, Bytes payload, Qos qos, const MessagePtr& message,
                   std::span<Receiver> receivers, Turn& turn) {
    waiting_.clear();
    for (Receiver& receiver : receivers) {
        if (is_member(receiver, topic, qos)) waiting_.push_back(&receiver);
    }
    while (waiting_.size() >= fewest_members) {
        const Endpoint via = waiting_.front()->session->header.via;
        members_.clear();
        std::erase_if(waiting_, [&](Receiver* each) {
            const bool is_here = each->session->header.via == via;
            if (is_here) members_.push_back(each);
            return is_here;
        });
        const mqttsn::MsgId behind =
            qos == Qos::at_least_once ? unanswered(members_) : mqttsn::no_msg_id;
        if (members_.size() < fewest_members || !find_exceptions(via, topic, members_)) continue;
        // Who shares its number with one of these is excepted with it.
        std::erase_if(members_, [&](const Receiver* each) {
            return std::ranges::binary_search(exceptions_, number_of(*each->session));
        });
        if (members_.size() < fewest_members) continue;
        send(members_, behind, topic, payload, qos, message, turn);
    }
}

bool Cell::is_member(const Receiver& receiver, std::string_view topic, Qos qos) const {
    Session& session = *receiver.session;
    WireTopic known = receiver.topic;
    return receiver.qos == qos && (qos == Qos::at_most_once || receiver.takes) &&
           session.header.via.family == tables_.options.cell_group.family && can_listen(session) &&
           deliveries_.can_take_now(session, known, topic, qos) &&
           tables_.subscribers.find(mqttsn::cell_topic, session.number) != nullptr;
}

bool Cell::find_exceptions(const Endpoint& via, std::string_view topic, const Members& members) {
    exceptions_.clear();
    bool all_may_read = true;
    tables_.subscribers.match(mqttsn::cell_topic, [&](SessionNumber number, const Grant&) {
        const Session& listener = *tables_.sessions.at(number);
        if (listener.header.via != via) return;
        if (tables_.permissions != nullptr &&
            !tables_.permissions->may_read(speaker_of(listener), topic)) {
            all_may_read = false;
        }
        const auto number_of_member = [](const Receiver* each) { return each->session->number; };
        const bool is_served = std::ranges::binary_search(members, number, {}, number_of_member);
        if (!is_served && listener.topics.find(topic) != mqttsn::no_topic_id) {
            exceptions_.push_back(number_of(listener));
        }
    });
    std::ranges::sort(exceptions_);
    const auto repeated = std::ranges::unique(exceptions_);
    exceptions_.erase(repeated.begin(), repeated.end());
    return all_may_read && exceptions_.size() <= mqttsn::most_cell_exceptions;
}

mqttsn::MsgId Cell::unanswered(Members& members) {
    Members waited_for;
    std::ranges::copy_if(members, std::back_inserter(waited_for),
                         [](const Receiver* each) { return each->session->exchange.is_open(); });
    if (waited_for.empty()) return mqttsn::no_msg_id;
    const std::uint16_t last = latest_msg_id(waited_for);
    std::erase_if(members,
                  [last](const Receiver* each) { return each->session->last_msg_id != last; });
    return mqttsn::MsgId{last};
}

/// The one behind which no listener was given any: it lies behind all of them on the circle of
/// numbers, so that no answer to an earlier message is taken for one to this.
std::uint16_t Cell::latest_msg_id(const Members& members) {
    std::uint16_t latest = members.front()->session->last_msg_id;
    for (const Receiver* member : members) {
        const std::uint16_t own = member->session->last_msg_id;
        const auto ahead = static_cast<std::int16_t>(static_cast<std::uint16_t>(own - latest));
        if (ahead > 0) latest = own;
    }
    return latest;
}

void Cell::send(Members& members, mqttsn::MsgId behind, std::string_view topic, Bytes payload,
                Qos qos, const MessagePtr& message, Turn& turn) {
    data_.assign(1, static_cast<std::uint8_t>(exceptions_.size()));
    for (const std::uint16_t number : exceptions_) {
        append_be16(data_, number);
    }
    const bool is_answered = qos == Qos::at_least_once;
    if (is_answered) append_be16(data_, static_cast<std::uint16_t>(behind));
    data_.insert(data_.end(), topic.begin(), topic.end());
    data_.insert(data_.end(), payload.begin(), payload.end());

    const unsigned steps = is_answered ? answer_steps_for(members.size()) : 0;
    mqttsn::Publish publish{.dup = false,
                            .qos = qos,
                            .retain = false,
                            .topic_type = mqttsn::TopicIdType::reserved,
                            .topic = mqttsn::cell_sizes(steps, topic),
                            .msg_id = mqttsn::no_msg_id,
                            .data = data_};
    const std::size_t size = mqttsn::encoded_size(publish);
    if (size > mqttsn::max_datagram || turn.out.is_full()) return;

    const std::uint16_t latest = latest_msg_id(members);
    const Duration until_repair = steps * Duration{mqttsn::cell_answer_step} +
                                  std::min(tables_.options.t_retry, Duration{patience});
    Seq after = 0;
    for (Receiver* member : members) {
        Session& session = *member->session;
        member->at_cell = true;
        after = std::max(after, session.output_floor);
        if (!is_answered) continue;
        session.last_msg_id = latest;
        // The same for all of them.
        publish.msg_id =
            deliveries_.follow_cell(session, message, member->topic, until_repair, turn);
    }
    // What follows to any of them must not overtake it.
    for (Receiver* member : members) member->session->output_floor = after;

    (void)mqttsn::encode(publish, turn.out.reserve(size));
    turn.out.push(
        Send{members.front()->session->header.via,
             ClientAddress{.endpoint = tables_.options.cell_group, .wireless_node_id = {}}, after,
             turn.out.commit(size), static_cast<std::uint32_t>(size)});
    ++tables_.counters.sent_by_type[static_cast<std::size_t>(mqttsn::MsgType::publish)];
    ++tables_.counters.publishes_sent;
    ++tables_.counters.cell_publishes;
    tables_.counters.cell_deliveries += members.size();
}

}  // namespace romano::broker
