#include "experiments/measure/delivery_account.h"

#include <algorithm>
#include <cassert>
#include <map>
#include <tuple>

namespace romano::experiments {
namespace {

/// `messages` are one publisher's, in the order in which he sent them. A publisher has one topic a
/// stream and receiver.
void count_out_of_order(const std::vector<PublishedMessage>& messages,
                        std::array<DeliveryTally, 3>& tallies) {
    std::map<std::tuple<RobotNumber, Stream, std::uint8_t>, double> later_one_came;
    for (auto message = messages.rbegin(); message != messages.rend(); ++message) {
        for (const Delivery& delivery : message->deliveries) {
            if (!delivery.first_at_s) continue;
            const auto [later, is_last] = later_one_came.try_emplace(
                {delivery.receiver, message->stream, message->qos}, *delivery.first_at_s);
            if (*delivery.first_at_s > later->second) ++tallies[message->qos].out_of_order;
            later->second = std::min(later->second, *delivery.first_at_s);
        }
    }
}

}  // namespace

std::optional<double> DeliveryTally::ratio() const {
    if (expected == 0) return std::nullopt;
    return static_cast<double>(delivered) / static_cast<double>(expected);
}

DeliveryTally& DeliveryTally::operator+=(const DeliveryTally& other) {
    published += other.published;
    acknowledged += other.acknowledged;
    expected += other.expected;
    delivered += other.delivered;
    duplicates += other.duplicates;
    acknowledged_but_lost += other.acknowledged_but_lost;
    out_of_order += other.out_of_order;
    return *this;
}

std::uint32_t DeliveryAccount::on_published(RobotNumber publisher, Stream stream, std::uint8_t qos,
                                            double sent_at_s,
                                            std::span<const RobotNumber> receivers) {
    assert(qos <= 2 && std::ranges::is_sorted(receivers));
    if (by_publisher_.size() <= publisher) by_publisher_.resize(publisher + 1);
    auto& messages = by_publisher_[publisher];
    const auto sequence = static_cast<std::uint32_t>(messages.size());
    PublishedMessage& message = messages.emplace_back(PublishedMessage{.publisher = publisher,
                                                                       .sequence = sequence,
                                                                       .stream = stream,
                                                                       .qos = qos,
                                                                       .sent_at_s = sent_at_s,
                                                                       .acknowledged_at_s = {},
                                                                       .deliveries = {}});
    for (const RobotNumber receiver : receivers) {
        message.deliveries.push_back({.receiver = receiver, .first_at_s = {}, .copies = 0});
    }
    if (qos > 0) {
        undelivered_ += receivers.size();
        ++unacknowledged_;
    }
    return sequence;
}

void DeliveryAccount::on_acknowledged(RobotNumber publisher, std::uint32_t sequence, double at_s) {
    assert(publisher < by_publisher_.size() && sequence < by_publisher_[publisher].size());
    PublishedMessage& message = by_publisher_[publisher][sequence];
    if (message.qos == 0 || message.acknowledged_at_s) return;
    message.acknowledged_at_s = at_s;
    --unacknowledged_;
}

bool DeliveryAccount::on_arrived(RobotNumber publisher, std::uint32_t sequence,
                                 RobotNumber receiver, double at_s) {
    if (publisher < by_publisher_.size() && sequence < by_publisher_[publisher].size()) {
        PublishedMessage& message = by_publisher_[publisher][sequence];
        auto& deliveries = message.deliveries;
        const auto delivery =
            std::ranges::lower_bound(deliveries, receiver, {}, &Delivery::receiver);
        if (delivery != deliveries.end() && delivery->receiver == receiver) {
            if (++delivery->copies == 1) {
                delivery->first_at_s = at_s;
                if (message.qos > 0) --undelivered_;
            }
            return true;
        }
    }
    ++strays_;
    return false;
}

std::array<DeliveryTally, 3> DeliveryAccount::tally_by_qos() const {
    std::array<DeliveryTally, 3> tallies;
    for (const auto& messages : by_publisher_) {
        count_out_of_order(messages, tallies);
        for (const PublishedMessage& message : messages) {
            DeliveryTally& tally = tallies[message.qos];
            const bool acknowledged = message.acknowledged_at_s.has_value();
            ++tally.published;
            if (acknowledged) ++tally.acknowledged;
            for (const Delivery& delivery : message.deliveries) {
                ++tally.expected;
                if (delivery.copies > 0) {
                    ++tally.delivered;
                    tally.duplicates += delivery.copies - 1;
                } else if (acknowledged) {
                    ++tally.acknowledged_but_lost;
                }
            }
        }
    }
    return tallies;
}

Percentiles DeliveryAccount::delays_ms() const {
    std::vector<double> delays;
    for (const auto& messages : by_publisher_) {
        for (const PublishedMessage& message : messages) {
            for (const Delivery& delivery : message.deliveries) {
                if (!delivery.first_at_s) continue;
                delays.push_back((*delivery.first_at_s - message.sent_at_s) * 1e3);
            }
        }
    }
    return Percentiles{std::move(delays)};
}

Percentiles DeliveryAccount::fan_out_delays_ms() const {
    std::vector<double> delays;
    for (const auto& messages : by_publisher_) {
        for (const PublishedMessage& message : messages) {
            const auto& deliveries = message.deliveries;
            if (message.stream != Stream::group || deliveries.empty()) continue;
            if (std::ranges::any_of(deliveries, [](auto& d) { return d.copies == 0; })) continue;
            const auto last = std::ranges::max_element(deliveries, {}, &Delivery::first_at_s);
            delays.push_back((*last->first_at_s - message.sent_at_s) * 1e3);
        }
    }
    return Percentiles{std::move(delays)};
}

}  // namespace romano::experiments
