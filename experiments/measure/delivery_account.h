// The books of one run: what each robot published, what was acknowledged to it, and what arrived
// where. Only afterwards are they compared, so that the account costs the load little.
//
// Times are seconds of the run's own clock, 0 at the start of the load.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "experiments/measure/percentile.h"

namespace romano::experiments {

/// Robots are numbered from 0, in the order in which they were started.
using RobotNumber = std::uint32_t;

enum class Stream : std::uint8_t { one_to_one, group };

/// What became of one (message, receiver) pair.
struct Delivery {
    RobotNumber receiver;
    std::optional<double> first_at_s;
    std::uint32_t copies = 0;
};

struct PublishedMessage {
    RobotNumber publisher;
    std::uint32_t sequence;  // counts each publisher's messages from 0
    Stream stream;
    std::uint8_t qos;  // 0, 1, 2
    double sent_at_s;
    std::optional<double> acknowledged_at_s;  // PUBACK or PUBCOMP; never for QoS 0
    std::vector<Delivery> deliveries;         // one a subscribed robot, ordered by its number
};

/// A (message, receiver) pair counts once in `expected`, and at most once in `delivered`.
struct DeliveryTally {
    std::uint64_t published = 0;              // messages
    std::uint64_t acknowledged = 0;           // messages
    std::uint64_t expected = 0;               // pairs
    std::uint64_t delivered = 0;              // pairs
    std::uint64_t duplicates = 0;             // copies beyond a pair's first
    std::uint64_t acknowledged_but_lost = 0;  // pairs: the promise that was broken
    /// Pairs whose first copy came behind that of a later message of the same publisher, topic and
    /// QoS.
    std::uint64_t out_of_order = 0;

    /// Delivered of expected; empty when nothing was expected.
    [[nodiscard]] std::optional<double> ratio() const;
    DeliveryTally& operator+=(const DeliveryTally& other);
};

class DeliveryAccount {
public:
    /// `receivers` are the robots subscribed, in ascending order. Returns the message's sequence
    /// number.
    std::uint32_t on_published(RobotNumber publisher, Stream stream, std::uint8_t qos,
                               double sent_at_s, std::span<const RobotNumber> receivers);
    void on_acknowledged(RobotNumber publisher, std::uint32_t sequence, double at_s);
    /// False when no such message was published, or not to this receiver: it is counted apart.
    bool on_arrived(RobotNumber publisher, std::uint32_t sequence, RobotNumber receiver,
                    double at_s);

    [[nodiscard]] std::array<DeliveryTally, 3> tally_by_qos() const;
    /// Send to first arrival, each delivered pair, in milliseconds.
    [[nodiscard]] Percentiles delays_ms() const;
    /// Send to the arrival at the last receiver of a group message that reached all of them.
    [[nodiscard]] Percentiles fan_out_delays_ms() const;
    [[nodiscard]] std::uint64_t strays() const { return strays_; }
    /// Every QoS 1 and 2 message was acknowledged and has arrived at all its receivers. QoS 0 may
    /// be lost for good, so nobody waits for it.
    [[nodiscard]] bool is_settled() const { return unacknowledged_ == 0 && undelivered_ == 0; }

    /// By publisher, then sequence.
    [[nodiscard]] const std::vector<std::vector<PublishedMessage>>& by_publisher() const {
        return by_publisher_;
    }

private:
    std::vector<std::vector<PublishedMessage>> by_publisher_;
    std::uint64_t unacknowledged_ = 0;  // messages of QoS 1 and 2
    std::uint64_t undelivered_ = 0;     // pairs of QoS 1 and 2
    std::uint64_t strays_ = 0;
};

}  // namespace romano::experiments
