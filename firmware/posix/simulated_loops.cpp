#include "firmware/posix/simulated_loops.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace romano::firmware {

SimulatedLoops::SimulatedLoops(const control::RomanoId& id, std::uint64_t seed, Body& body,
                               Publish publish, Say say)
    : body_(body),
      publish_(std::move(publish)),
      say_(std::move(say)),
      plant_({.id = id, .seed = seed}),
      controller_(id) {}

void SimulatedLoops::on_message(Instant now, Bytes message) {
    move_on(now);
    plant_.on_message(now, message, *this);
    controller_.on_message(now, message, *this);
}

bool SimulatedLoops::run(Instant now) {
    if (next_wakeup() > now) return false;
    move_on(now);
    plant_.on_tick(now, *this);
    controller_.on_tick(now, *this);
    return true;
}

Instant SimulatedLoops::next_wakeup() const {
    return std::min(plant_.next_wakeup(), controller_.next_wakeup());
}

void SimulatedLoops::move_on(Instant now) {
    now_ = now;
    if (speed_.mm_s != 0 || speed_.deg_s != 0) {
        body_.go_on(speed_, std::chrono::duration<double>(now - moved_at_).count());
    }
    moved_at_ = now;
}

std::size_t SimulatedLoops::sense(control::Channel, MutableBytes room) {
    const auto location = body_.location();
    std::copy(location.begin(), location.end(), room.begin());
    return location.size();
}

void SimulatedLoops::carry_out(control::Channel, Bytes value) {
    speed_ = speed_of(value).value_or(Speed{});  // who says nothing that it knows stops it
}

void SimulatedLoops::fall_back(control::Channel, control::Fallback fallback) {
    if (fallback != control::Fallback::hold) speed_ = {};
}

bool SimulatedLoops::may_open(const control::Open& open) {
    return open.fallback != control::Fallback::own_law;  // it has none
}

void SimulatedLoops::on_state(control::Channel, control::State state, control::Reason reason) {
    const std::string by = " by " + std::string{plant_.loops()[0].controller().text()};
    switch (state) {
        case control::State::free:
            return say_("is no longer controlled" + by + ": " +
                        std::string{control::name_of(reason)});
        case control::State::inviting:
            return say_("is to be controlled" + by);
        case control::State::waiting:
            return say_("is not controlled" + by + " now");
        case control::State::controlled:
            return say_("is controlled" + by);
    }
}

bool SimulatedLoops::begin(control::Place place, const control::Invite& invite) {
    const auto law = Leading::parse(static_cast<std::uint16_t>(invite.law), invite.parameters);
    if (!law) return false;
    laws_.at(static_cast<std::size_t>(place)) = law;
    say_("controls " + std::string{invite.plant.text()});
    return true;
}

std::optional<std::size_t> SimulatedLoops::control(control::Place place,
                                                   const control::Sample& sample,
                                                   MutableBytes room) {
    const auto& law = laws_.at(static_cast<std::size_t>(place));
    const auto plant = pose_of(sample.value);
    if (!law || !plant) return std::nullopt;
    const auto speed = octets_of(law->speed_for(*plant, body_.pose()));
    std::copy(speed.begin(), speed.end(), room.begin());
    return speed.size();
}

void SimulatedLoops::on_end(control::Place place, control::Reason reason) {
    const auto& loop = controller_.loops()[static_cast<std::size_t>(place)];
    say_("no longer controls " + std::string{loop.plant().text()} + ": " +
         std::string{control::name_of(reason)});
}

}  // namespace romano::firmware
