#include "broker/uplink/uplink_core.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <utility>

#include "romano/base/fnv1a.h"
#include "romano/mqttsn/topic.h"

namespace romano::uplink {

using broker::Delivery;
using broker::LogPosition;
using mqttsn::Qos;

namespace {

// "~SESSION/PACKET_ID-DIGEST": no network's name begins so.
constexpr char without_name = '~';

std::string hex(std::uint64_t number) {
    std::array<char, 16> digits{};
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), number, 16).ptr;
    return {digits.data(), end};
}

std::uint64_t digest(const FromRemote& message) {
    Fnv1a<std::uint64_t> sum;
    sum.add(message.topic);
    sum.add(std::uint8_t{0});
    for (const std::uint8_t octet : message.payload) sum.add(octet);
    return sum.value();
}

}  // namespace

UplinkCore::UplinkCore(const UplinkOptions& options, std::uint64_t unique)
    : network_(options.network), rules_(options.rules), unique_(unique) {}

void UplinkCore::hold(bool holds, std::vector<UplinkAction>& out) {
    if (holds == holds_) return;
    holds_ = holds;
    up_ = false;
    on_their_way_.clear();
    is_busy_ = false;
    if (holds) {
        out.emplace_back(OpenLink{});
    } else {
        out.emplace_back(CloseLink{});
    }
}

void UplinkCore::on_up(bool resumed) {
    up_ = holds_;
    came_.reset();
    // A session that is new at the MQTT broker counts its packet ids anew.
    if (!resumed || mqtt_session_.empty()) {
        begin_mqtt_session(hex(unique_) + '.' + hex(++counted_));
    }
}

void UplinkCore::send(std::span<const Delivery> waiting, const LogPosition& safe,
                      std::vector<UplinkAction>& out) {
    is_busy_ = is_busy_ && !on_their_way_.empty();
    if (!up_ || is_busy_) return;
    std::size_t seen = 0;
    for (const Delivery& delivery : waiting) {
        if (seen++ >= window || on_their_way_.size() >= window) return;
        const LogPosition& position = delivery.position;
        if (!delivery.message || std::ranges::count(on_their_way_, position) != 0) continue;
        if (position.log == safe.log && position.seq > safe.seq) return;
        const auto place = rules_.to_remote(delivery.message->topic, delivery.qos);
        if (!place) {
            out.emplace_back(Discard{position});
            continue;
        }
        on_their_way_.push_back(position);
        ++counters_.sent;
        out.emplace_back(
            PublishUp{delivery.message, place->topic, place->qos, identity_of(position)});
    }
}

void UplinkCore::send_now(const broker::MessagePtr& message, std::vector<UplinkAction>& out) {
    const auto place = rules_.to_remote(message->topic, Qos::at_most_once);
    if (!place || !holds_) return;
    if (!up_) {
        ++counters_.dropped;
        return;
    }
    ++counters_.sent;
    out.emplace_back(PublishUp{message, place->topic, place->qos,
                               network_ + '/' + hex(unique_) + "/q" + hex(++counted_)});
}

void UplinkCore::send_retained(std::span<const broker::MessagePtr> retained,
                               std::span<const Delivery> waiting, std::vector<UplinkAction>& out) {
    for (const broker::MessagePtr& message : retained) {
        const auto place = rules_.to_remote(message->topic, message->qos);
        const bool waits = std::ranges::count(waiting, message->position, &Delivery::position) != 0;
        if (!place || waits || !message->origin.empty()) continue;
        ++counters_.sent;
        out.emplace_back(
            PublishUp{message, place->topic, place->qos, identity_of(message->position)});
    }
}

void UplinkCore::on_answer(const LogPosition& position, Answer answer) {
    if (std::erase(on_their_way_, position) == 0) return;
    if (answer == Answer::done) {
        ++counters_.confirmed;
    } else {
        ++counters_.busy;
        is_busy_ = true;
    }
}

std::optional<Inbound> UplinkCore::receive(const FromRemote& message) {
    ++counters_.received;
    const bool is_first = !came_[message.packet_id];
    came_.set(message.packet_id);
    const auto place = rules_.to_local(message.topic, message.qos);
    if (!place) {
        ++counters_.unwanted;
        return std::nullopt;
    }
    const bool named = !message.identity.empty() && message.identity.size() <= longest_identity &&
                       message.identity.front() != without_name;
    if (named && message.identity.starts_with(network_ + '/')) {
        ++counters_.own;
        return std::nullopt;
    }
    std::string origin = named ? message.identity : identity_of(message);
    if (named ? seen_.contains(origin) : is_first && is_newest(message)) {
        ++counters_.duplicates;
        return std::nullopt;
    }
    return Inbound{*place, std::move(origin)};
}

void UplinkCore::remember(const std::string& origin) {
    if (origin.ends_with('/')) return;  // of QoS 0, without a name
    const bool is_new = seen_.add(origin);
    if (origin.front() != without_name) return;
    const std::size_t slash = origin.find('/');
    std::string session = origin.substr(1, slash - 1);
    if (session != mqtt_session_) {
        if (!is_new) return;
        begin_mqtt_session(std::move(session));
    }
    note_newest(std::string_view{origin}.substr(slash + 1));
}

void UplinkCore::begin_mqtt_session(std::string name) {
    mqtt_session_ = std::move(name);
    newest_.clear();
}

void UplinkCore::note_newest(std::string_view packet) {
    const char* const end = packet.data() + packet.size();
    std::uint16_t id = 0;
    std::uint64_t sum = 0;
    const auto behind_id = std::from_chars(packet.data(), end, id).ptr;
    if (behind_id == end || std::from_chars(behind_id + 1, end, sum, 16).ptr != end) return;
    newest_.resize(packet_ids);
    newest_[id] = sum;
}

bool UplinkCore::is_newest(const FromRemote& message) const {
    if (message.packet_id == 0 || newest_.empty()) return false;  // QoS 0 comes once
    return newest_[message.packet_id] == digest(message);
}

std::string UplinkCore::identity_of(const LogPosition& position) const {
    return network_ + '/' + hex(static_cast<std::uint64_t>(position.log.broker)) + '.' +
           hex(position.log.incarnation) + '/' + std::to_string(position.seq);
}

std::string UplinkCore::identity_of(const FromRemote& message) const {
    std::string name = without_name + mqtt_session_ + '/';
    if (message.packet_id == 0) return name;  // QoS 0 comes once, and is not remembered
    return name + std::to_string(message.packet_id) + '-' + hex(digest(message));
}

}  // namespace romano::uplink
