#include "experiments/applications/row_of_cells.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "broker/net/clock.h"

namespace romano::experiments {
namespace {

constexpr double newest_counts = 0.25;  // of the strength that a board tells

std::string ip(const BrokerAddress& broker) {
    return broker.address().to_string();
}

}  // namespace

RowOfCells::RowOfCells(const std::string& network, std::uint16_t port, std::size_t brokers,
                       const RowShape& shape)
    : shape_(shape) {
    for (std::size_t i = 1; i <= brokers; ++i) {
        brokers_.emplace_back(boost::asio::ip::make_address(network + "." + std::to_string(i)),
                              port);
    }
}

std::string RowOfCells::address(std::size_t i) const {
    return ip(brokers_[i]) + ":" + std::to_string(brokers_[i].port());
}

Place RowOfCells::place_of(std::size_t broker) const {
    return {.x_m = static_cast<double>(broker) * shape_.metres_between};
}

double RowOfCells::lap_s() const {
    return 2 * place_of(brokers_.size() - 1).x_m / shape_.metres_a_second;
}

Place RowOfCells::place_after(double seconds) const {
    const double end = place_of(brokers_.size() - 1).x_m;
    const double way = std::fmod(seconds * shape_.metres_a_second, 2 * end);
    return {.x_m = std::min(way, 2 * end - way), .y_m = shape_.metres_aside};
}

RowRadio::RowRadio(const RowOfCells& row, std::uint64_t seed) : row_(row) {
    for (std::size_t i = 0; i < row.brokers(); ++i) {
        romano_address address{};
        (void)romano_udp_address(ip(row.broker(i)).c_str(), row.broker(i).port(), &address);
        brokers_.push_back({address, RadioLink{RadioModel{}, seed * 100 + i}, std::nullopt});
    }
}

void RowRadio::set_out() {
    set_out_at_ = net::now();
}

void RowRadio::stop() {
    stopped_at_ = net::now();
}

double RowRadio::seconds() const {
    if (set_out_at_ == never) return 0;
    const Instant until = std::min(net::now(), stopped_at_);
    return std::chrono::duration<double>(until - set_out_at_).count();
}

std::size_t RowRadio::index_of(const romano_address& peer) const {
    const auto same = [&](const Broker& broker) {
        return std::memcmp(broker.address.ip, peer.ip, sizeof peer.ip) == 0;
    };
    return static_cast<std::size_t>(std::ranges::find_if(brokers_, same) - brokers_.begin());
}

bool RowRadio::carries(std::size_t broker) {
    if (broker >= brokers_.size()) return false;
    Broker& peer = brokers_[broker];
    const double dbm = peer.link.packet_dbm(row_.place_after(seconds()), row_.place_of(broker));
    const bool received = peer.link.is_received(dbm);
    if (!received) {
        ++lost_;
    } else {
        const double before = peer.heard_dbm.value_or(dbm);
        peer.heard_dbm = before + newest_counts * (dbm - before);
    }
    return received;
}

std::vector<romano_address> RowRadio::neighbours() {
    std::vector<romano_address> all;
    for (const Broker& broker : brokers_) all.push_back(broker.address);
    broadcasts_left_ = all.size();
    return all;
}

bool RowRadio::carries_to(const romano_address& peer) {
    const std::size_t broker = index_of(peer);
    if (broadcasts_left_ > 0) {
        --broadcasts_left_;
        // Heard at another time than before: what was known of it is old.
        if (broker < brokers_.size() && talks_to_ != broker) brokers_[broker].heard_dbm.reset();
        return carries(broker);
    }
    if (talks_to_ != broker) {
        if (talks_to_) moves_.push_back({.begun_at = net::now()});
        talks_to_ = broker;
    }
    note_strength();
    return carries(broker);
}

bool RowRadio::carries_from(const romano_address& peer) {
    const std::size_t broker = index_of(peer);
    if (!carries(broker)) return false;
    if (broker == talks_to_ && !moves_.empty() && moves_.back().done_at == never) {
        moves_.back().done_at = net::now();
    }
    note_strength();
    return true;
}

std::optional<int> RowRadio::dbm(const romano_address& peer) {
    const std::size_t broker = index_of(peer);
    if (broker >= brokers_.size() || !brokers_[broker].heard_dbm) return std::nullopt;
    return static_cast<int>(std::lround(*brokers_[broker].heard_dbm));
}

/// Ten times a second, for the picture.
void RowRadio::note_strength() {
    if (set_out_at_ == never || stopped_at_ != never || !talks_to_) return;
    const double now = seconds();
    if (!strengths_.empty() && now < strengths_.back().at_s + 0.1) return;
    Strength at{.at_s = now, .dbm = {}, .chosen = *talks_to_};
    for (std::size_t i = 0; i < brokers_.size(); ++i) {
        at.dbm.push_back(brokers_[i].link.packet_dbm(row_.place_after(now), row_.place_of(i)));
    }
    strengths_.push_back(std::move(at));
}

}  // namespace romano::experiments
