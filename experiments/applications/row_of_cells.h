// Brokers in a row, a cell each, and the radio of a robot that drives up and down beside them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "experiments/robots/socket_client.h"
#include "firmware/posix/radio_board.h"
#include "overlay/radio/propagation.h"
#include "romano/base/time.h"

namespace romano::experiments {

using radio::Place;
using radio::RadioLink;
using radio::RadioModel;

struct RowShape {
    double metres_between = 12;
    double metres_a_second = 3;
    double metres_aside = 3;  // of the robots' way
};

class RowOfCells {
public:
    /// Broker i is at `network`.(i + 1).
    RowOfCells(const std::string& network, std::uint16_t port, std::size_t brokers,
               const RowShape& shape);

    [[nodiscard]] std::size_t brokers() const { return brokers_.size(); }
    [[nodiscard]] const BrokerAddress& broker(std::size_t i) const { return brokers_[i]; }
    [[nodiscard]] std::string address(std::size_t i) const;
    [[nodiscard]] Place place_of(std::size_t broker) const;
    /// Of a robot so long after it set out at the first broker.
    [[nodiscard]] Place place_after(double seconds) const;
    /// There and back.
    [[nodiscard]] double lap_s() const;

private:
    std::vector<BrokerAddress> brokers_;
    RowShape shape_;
};

/// From the first datagram to the new broker until the first from it.
struct Move {
    Instant begun_at;
    Instant done_at = never;
};
/// How strongly each broker would be heard.
struct Strength {
    double at_s;
    std::vector<double> dbm;
    std::size_t chosen;
};

class RowRadio final : public firmware::Radio {
public:
    RowRadio(const RowOfCells& row, std::uint64_t seed);

    /// Until then, and after stop(), it stands.
    void set_out();
    void stop();

    std::vector<romano_address> neighbours() override;
    bool carries_to(const romano_address& peer) override;
    bool carries_from(const romano_address& peer) override;
    std::optional<int> dbm(const romano_address& peer) override;

    [[nodiscard]] const std::vector<Move>& moves() const { return moves_; }
    [[nodiscard]] const std::vector<Strength>& strengths() const { return strengths_; }
    [[nodiscard]] std::uint64_t lost() const { return lost_; }

private:
    struct Broker {
        romano_address address;
        RadioLink link;
        std::optional<double> heard_dbm;
    };

    [[nodiscard]] double seconds() const;
    [[nodiscard]] std::size_t index_of(const romano_address& peer) const;
    bool carries(std::size_t broker);
    void note_strength();

    const RowOfCells& row_;
    std::vector<Broker> brokers_;
    Instant set_out_at_ = never;
    Instant stopped_at_ = never;
    std::size_t broadcasts_left_ = 0;
    std::optional<std::size_t> talks_to_;
    std::vector<Move> moves_;
    std::vector<Strength> strengths_;
    std::uint64_t lost_ = 0;
};

}  // namespace romano::experiments
