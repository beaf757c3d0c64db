// The service addresses of this broker: its own by configuration, and those it answers on now, its
// own or taken over.
#pragma once

#include <algorithm>
#include <set>
#include <vector>

#include "overlay/cluster/effects.h"

namespace romano::cluster {

class ServiceAddresses {
public:
    explicit ServiceAddresses(std::vector<Endpoint> home) : home_(std::move(home)) {}

    [[nodiscard]] const std::vector<Endpoint>& home() const { return home_; }
    [[nodiscard]] bool is_home(const Endpoint& address) const {
        return std::ranges::count(home_, address) > 0;
    }
    [[nodiscard]] bool is_serving(const Endpoint& address) const {
        return serving_.contains(address);
    }
    /// With those that are being taken: nobody else shall take them meanwhile.
    [[nodiscard]] std::vector<Endpoint> claimed() const {
        std::set<Endpoint> all = serving_;
        all.insert(taking_.begin(), taking_.end());
        return {all.begin(), all.end()};
    }
    [[nodiscard]] const std::set<Endpoint>& serving() const { return serving_; }

    void take(Effects& effects, const Endpoint& address) {
        if (is_serving(address) || !taking_.insert(address).second) return;
        effects.local.push_back(TakeAddress{address});
    }
    void give_up(Effects& effects, const Endpoint& address) {
        taking_.erase(address);
        serving_.erase(address);
        effects.local.push_back(GiveUpAddress{address});
    }
    void on_address(const Endpoint& address, bool served) {
        taking_.erase(address);
        if (served) {
            serving_.insert(address);
        } else {
            serving_.erase(address);
        }
    }

private:
    std::vector<Endpoint> home_;
    std::set<Endpoint> serving_;
    std::set<Endpoint> taking_;  // asked for, not answered yet
};

}  // namespace romano::cluster
