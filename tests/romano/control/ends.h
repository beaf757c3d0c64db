// The two ends of a loop as tests see them: what they say waits in a list, what they do is noted.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "romano/control/controller.h"
#include "romano/control/plant.h"

namespace romano::control {

using Octets = std::vector<std::uint8_t>;

inline const RomanoId plant_id = *RomanoId::parse("00000001");
inline const RomanoId controller_id = *RomanoId::parse("00000002");
inline const RomanoId operator_id = *RomanoId::parse("00000003");

struct Said {
    RomanoId to;
    Octets octets;
    mqttsn::Qos qos;

    template <typename M>
    [[nodiscard]] std::optional<M> as() const {
        const auto message = decode(octets);
        if (!message) return std::nullopt;
        const M* const found = std::get_if<M>(&*message);
        return found == nullptr ? std::nullopt : std::optional<M>{*found};
    }
};

/// The messages of one kind, taken out of a list of all. Their views are into the list.
template <typename M>
std::vector<M> all_of(const std::vector<Said>& said) {
    std::vector<M> found;
    for (const Said& each : said) {
        if (const auto message = each.as<M>()) found.push_back(*message);
    }
    return found;
}

template <typename M>
Octets octets_of(const M& message) {
    Octets room(255);
    room.resize(encode(message, room));
    return room;
}

inline Open open_with(Session ticket) {
    return {.channel = Channel{0},
            .ticket = ticket,
            .asker = operator_id,
            .controller = controller_id,
            .law = Law{1},
            .period_ms = 20,
            .deadline_ms = 100,
            .lease_s = 0,
            .fallback = Fallback::stop,
            .ends_then = false,
            .parameters = {}};
}

struct PlantEnd final : PlantPort {
    void publish(const RomanoId& to, Bytes message, mqttsn::Qos qos) override {
        said.push_back({to, {message.begin(), message.end()}, qos});
    }
    std::size_t sense(Channel, MutableBytes room) override {
        room[0] = ++sensed;
        return 1;
    }
    void carry_out(Channel, Bytes value) override { did.emplace_back(value.begin(), value.end()); }
    void fall_back(Channel, Fallback fallback) override { falls.push_back(fallback); }
    bool may_open(const Open&) override { return is_willing; }
    void on_state(Channel, State state, Reason reason) override {
        states.emplace_back(state, reason);
    }

    std::vector<Said> said;
    std::vector<Octets> did;
    std::vector<Fallback> falls;
    std::vector<std::pair<State, Reason>> states;
    std::uint8_t sensed = 0;
    bool is_willing = true;
};

struct ControllerEnd final : ControllerPort {
    void publish(const RomanoId& to, Bytes message, mqttsn::Qos qos) override {
        said.push_back({to, {message.begin(), message.end()}, qos});
    }
    bool begin(Place place, const Invite& invite) override {
        if (invite.law != Law{1}) return false;
        begun.push_back(place);
        return true;
    }
    std::optional<std::size_t> control(Place, const Sample& sample, MutableBytes room) override {
        samples.emplace_back(sample.value.begin(), sample.value.end());
        if (is_mute) return std::nullopt;
        std::copy(sample.value.begin(), sample.value.end(), room.begin());
        return sample.value.size();
    }
    void on_end(Place place, Reason reason) override { ended.emplace_back(place, reason); }

    std::vector<Said> said;
    std::vector<Place> begun;
    std::vector<Octets> samples;
    std::vector<std::pair<Place, Reason>> ended;
    bool is_mute = false;
};

}  // namespace romano::control
