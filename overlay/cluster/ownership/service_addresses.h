// The service addresses of this broker: its own by configuration, and those it answers on now, its
// own or taken over.
#pragma once

#include <algorithm>
#include <cstddef>
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
    /// Whether the machine would serve a peer's address.
    void on_ability(const Endpoint& address, bool can_take) {
        if (can_take) {
            cannot_take_.erase(address);
        } else if (cannot_take_.size() < cannot_take_most) {
            cannot_take_.insert(address);
        }
    }
    [[nodiscard]] std::vector<Endpoint> cannot_take() const {
        return {cannot_take_.begin(), cannot_take_.end()};
    }
    /// Also names addresses that are being taken: nobody else shall take them meanwhile.
    [[nodiscard]] std::vector<Endpoint> claimed() const {
        std::set<Endpoint> all = serving_;
        all.insert(taking_.begin(), taking_.end());
        return {all.begin(), all.end()};
    }
    [[nodiscard]] const std::set<Endpoint>& serving() const { return serving_; }
    /// The machine was asked to serve the address, and has not answered yet.
    [[nodiscard]] bool is_taking(const Endpoint& address) const {
        return taking_.contains(address);
    }

    /// We serve the address, or shall soon.
    [[nodiscard]] bool is_claimed(const Endpoint& address) const {
        return is_serving(address) || is_taking(address);
    }

    void take(Effects& effects, const Endpoint& address) {
        if (is_serving(address) || !taking_.insert(address).second) return;
        effects.local.push_back(TakeAddress{address});
    }
    /// Another broker serves it as well: datagrams shall come here.
    static void take_anew(Effects& effects, const Endpoint& address) {
        effects.local.push_back(TakeAddress{address});
    }
    /// The other broker has let it go, and may have called datagrams to itself until then.
    static void announce(Effects& effects, const Endpoint& address) {
        effects.local.push_back(AnnounceAddress{address});
    }
    /// Takes over an address that lost its broker: tried again until it works.
    void inherit(Effects& effects, const Endpoint& address) {
        inherited_.insert(address);
        take(effects, address);
    }
    /// Tries again for what was inherited, but is not served yet: until somebody else serves it.
    template <typename IsHeld>
    void seek(Effects& effects, IsHeld&& is_held) {
        std::erase_if(inherited_, [&](const Endpoint& address) {
            return !is_claimed(address) && is_held(address);
        });
        for (const Endpoint& address : inherited_) take(effects, address);
    }
    void give_up(Effects& effects, const Endpoint& address) {
        taking_.erase(address);
        serving_.erase(address);
        inherited_.erase(address);
        effects.local.push_back(GiveUpAddress{address});
    }
    /// Gives up every address, and seeks none any more.
    void give_up_all(Effects& effects) {
        for (const Endpoint& address : claimed()) give_up(effects, address);
        inherited_.clear();
        adopted_.clear();
    }
    /// Sessions of that address were adopted, whoever serves it (strays.h).
    void on_adopted(const Endpoint& address) { adopted_.insert(address); }
    void forget_adopted(const Endpoint& address) { adopted_.erase(address); }
    [[nodiscard]] const std::set<Endpoint>& adopted() const { return adopted_; }
    void on_address(const Endpoint& address, bool served) {
        taking_.erase(address);
        if (served) {
            serving_.insert(address);
        } else {
            serving_.erase(address);
        }
    }

private:
    static constexpr std::size_t cannot_take_most = 1'000;

    std::vector<Endpoint> home_;
    std::set<Endpoint> serving_;
    std::set<Endpoint> taking_;  // none of those that are served
    std::set<Endpoint> inherited_;
    std::set<Endpoint> adopted_;
    std::set<Endpoint> cannot_take_;
};

}  // namespace romano::cluster
