// A broker core and the stations of its cell, on one lossless link without delay; a test owns the
// time.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <utility>
#include <vector>

#include "broker/core/broker_core.h"
#include "romano/base/bytes.h"
#include "romano/base/endpoint.h"
#include "romano/base/time.h"

namespace romano::node {

inline Endpoint endpoint(std::uint16_t port) {
    Endpoint address;
    address.family = Endpoint::Family::ipv4;
    address.address = {127, 0, 0, 1};
    address.port = port;
    return address;
}

/// Whoever has an address in the cell.
class Station {
public:
    explicit Station(std::uint16_t port) : address_(endpoint(port)) {}
    virtual ~Station() = default;
    virtual void on_datagram(Instant now, Bytes datagram) = 0;
    virtual void on_tick(Instant now) = 0;
    [[nodiscard]] const Endpoint& address() const { return address_; }

private:
    Endpoint address_;
};

class Cell {
public:
    void join(Station& station) { stations_[station.address()] = &station; }

    void from_station(const Station& from, Bytes datagram) {
        to_broker_.push_back({from.address(), {datagram.begin(), datagram.end()}});
    }

    /// Until nothing is under way.
    void settle() {
        while (!to_broker_.empty()) {
            const auto [from, octets] = std::move(to_broker_.front());
            to_broker_.pop_front();
            broker_.on_datagram(now_, endpoint(1883), from, octets, actions_);
            deliver();
        }
    }

    void run_for(Duration time) {
        for (const Instant end = now_ + time; now_ < end; now_ += std::chrono::milliseconds{50}) {
            for (auto& [address, station] : stations_) station->on_tick(now_);
            broker_.on_tick(now_, actions_);
            deliver();
            settle();
        }
    }

    /// Its sessions are gone.
    void replace_broker() { broker_ = broker::BrokerCore(broker::BrokerOptions{}, 2); }
    [[nodiscard]] Instant now() const { return now_; }

private:
    void deliver() {
        std::vector<std::pair<Station*, std::vector<std::uint8_t>>> arrivals;
        for (const auto& action : actions_.list()) {
            const auto* send = std::get_if<broker::Send>(&action);
            if (send == nullptr) continue;
            const auto station = stations_.find(send->to.endpoint);
            if (station == stations_.end()) continue;
            const Bytes octets = actions_.octets(*send);
            arrivals.push_back({station->second, {octets.begin(), octets.end()}});
        }
        actions_.clear();
        for (const auto& [station, octets] : arrivals) station->on_datagram(now_, octets);
    }

    broker::BrokerCore broker_{broker::BrokerOptions{}, 1};
    broker::Actions actions_;
    Instant now_{};
    std::map<Endpoint, Station*> stations_;
    std::deque<std::pair<Endpoint, std::vector<std::uint8_t>>> to_broker_;
};

}  // namespace romano::node
