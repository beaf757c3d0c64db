#include "overlay/sim/dtls_ends.h"

#include <algorithm>
#include <utility>

#include "broker/dtls/own_id.h"
#include "broker/protection/protected_node.h"
#include "romano/mqttsn/frame.h"

namespace romano::sim {
namespace {

using Octets = DtlsRecords::Octets;

constexpr std::size_t most_waiting = 16;
constexpr unsigned unanswered_connects = 2;

// A question: eight octets, whether an id is wanted, the robot's name. An answer: the first eight
// octets, and the association's id.
constexpr std::size_t name_at = 9;
constexpr std::size_t answer_octets = 16;

Octets handshake_record(Bytes body) {
    Octets out(dtls::header_octets);
    dtls::put_header(out, dtls::ContentType::handshake, 0, {}, body.size());
    out.insert(out.end(), body.begin(), body.end());
    return out;
}

std::uint64_t draw64(Random& random) {
    return std::uint64_t{random.next()} << 32U | random.next();
}

}  // namespace

// --- a robot's

DtlsRobotEnd::DtlsRobotEnd(std::string robot, bool wants_id, DtlsRecords& world, std::uint64_t seed)
    : robot_(std::move(robot)), wants_id_(wants_id), world_(world), random_(seed) {}

void DtlsRobotEnd::send(Bytes message, const Put& put) {
    if (is_handshake_due(message)) {
        question_ = draw64(random_);
        world_.on_asked(*question_);
        records_.reset();
        was_heard_ = false;
        unanswered_ = 0;
        waiting_.clear();
    }
    if (!question_) return seal(message, put);
    if (waiting_.size() == most_waiting) waiting_.erase(waiting_.begin());
    waiting_.emplace_back(message.begin(), message.end());
    ask(put);
}

bool DtlsRobotEnd::is_handshake_due(Bytes message) {
    if (!question_ && !records_) return true;
    const auto frame = mqttsn::decode_frame(message);
    if (!frame || frame->type != mqttsn::MsgType::connect) return false;
    return was_heard_ || ++unanswered_ == unanswered_connects;
}

void DtlsRobotEnd::ask(const Put& put) {
    Octets body(name_at);
    dtls::put_be64(body, 0, *question_);
    body[8] = wants_id_ ? 1 : 0;
    body.insert(body.end(), robot_.begin(), robot_.end());
    put(handshake_record(body));
}

void DtlsRobotEnd::seal(Bytes message, const Put& put) {
    const Bytes record = records_->seal(dtls::ContentType::application_data, message);
    world_.on_robot_sealed(id_, record, message);
    put(record);
}

Bytes DtlsRobotEnd::open(Bytes datagram, const Put& put) {
    const auto record = dtls::first_record(datagram);
    if (!record) return {};
    if (record->epoch == 0) {
        const Octets* answer = question_ ? world_.answered(*question_) : nullptr;
        if (answer != nullptr && std::ranges::equal(*answer, datagram)) on_answer(*answer, put);
        return {};
    }
    const auto heard = records_ ? records_->open(*record) : std::nullopt;
    if (!heard || heard->type != dtls::ContentType::application_data) return {};
    was_heard_ = true;
    return heard->message;
}

void DtlsRobotEnd::on_answer(Bytes answer, const Put& put) {
    const Bytes id = answer.last(8);
    id_ = dtls::own_id_of(id);
    records_.emplace(DtlsRecords::keys_of(robot_, *question_),
                     wants_id_ ? *dtls::ConnectionId::of(id) : dtls::ConnectionId{}, 1);
    question_.reset();
    for (const auto& message : std::exchange(waiting_, {})) seal(message, put);
}

void DtlsRobotEnd::on_other_broker() {
    if (wants_id_) return;
    question_.reset();
    records_.reset();
}

// --- a broker's

DtlsBrokerEnd::DtlsBrokerEnd(std::string life, std::uint32_t place, std::uint32_t bound,
                             DtlsRecords& world, std::span<const broker::ProtectedClient> clients,
                             std::uint64_t seed)
    : life_(std::move(life)),
      place_(place),
      world_(world),
      random_(seed),
      reserve_(bound),
      clients_({place, reserve_}) {
    clients_.set_clients(clients);
}

void DtlsBrokerEnd::take(const dtls::Path& path, Bytes datagram, broker::Actions& out,
                         const Deliver& deliver) {
    const auto record = dtls::first_record(datagram, dtls::own_id_octets);
    if (!record) return;
    if (record->epoch == 0) return on_question(path, record->body, out);
    const dtls::Message message = clients_.open(path, *record, out);
    if (message.octets.empty()) return;
    // In front stands who it is.
    world_.on_taken(life_, record->whole, message.octets.subspan(message.octets[0]));
    deliver(message);
}

void DtlsBrokerEnd::on_question(const dtls::Path& path, Bytes body, broker::Actions& out) {
    if (body.size() < name_at) return;
    const std::uint64_t question = dtls::be64(body, 0);
    const std::string robot{as_text(body.subspan(name_at))};
    if (!world_.was_asked(question) || clients_.key_of(robot) == nullptr) return;
    if (world_.answered(question) == nullptr) {
        const auto id = dtls::own_id(place_, draw64(random_));
        const dtls::RecordKeys keys = DtlsRecords::keys_of(robot, question);
        const bool wants_id = body[8] != 0;
        clients_.add(
            {robot, id, path, keys, wants_id ? std::optional{dtls::ConnectionId{}} : std::nullopt});
        Octets answer(answer_octets);
        dtls::put_be64(answer, 0, question);
        dtls::put_be64(answer, 8, static_cast<std::uint64_t>(id));
        world_.on_answered(question, id, keys, handshake_record(answer));
    }
    out.push(broker::Send{.via = path.via, .to = {path.from, {}}}, *world_.answered(question));
}

void DtlsBrokerEnd::seal(broker::Actions& actions) {
    clients_.seal(actions);
    for (const broker::Action& action : actions.list()) {
        const auto* send = std::get_if<broker::Send>(&action);
        if (send == nullptr || !broker::is_dtls(send->via)) continue;
        world_.on_broker_sealed(actions.octets(*send));
    }
}

}  // namespace romano::sim
