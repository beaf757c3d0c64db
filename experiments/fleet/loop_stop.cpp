#include "experiments/fleet/loop_stop.h"

#include <array>
#include <chrono>
#include <cstddef>
#include <variant>

namespace romano::experiments {
namespace {

constexpr std::chrono::seconds answers_within{10};
constexpr unsigned most_channels = 16;

template <typename Message>
Octets encoded_for_loop(const Message& message) {
    std::array<std::uint8_t, control::largest_message> octets{};
    const std::size_t size = control::encode(message, octets);
    return {octets.begin(), octets.begin() + static_cast<std::ptrdiff_t>(size)};
}

}  // namespace

LoopStop::ToRobot LoopStop::begin(Instant now, const message::RomanoId& robot) {
    for (; !in_order_.empty() && now - in_order_.front().first > answers_within;
         in_order_.pop_front()) {
        const auto old = begun_.find(in_order_.front().second);
        if (old != begun_.end() && old->second == in_order_.front().first) begun_.erase(old);
    }
    begun_[robot] = now;
    in_order_.emplace_back(now, robot);
    return ask(robot, control::Channel{0});
}

LoopStop::ToRobot LoopStop::ask(const message::RomanoId& robot, control::Channel channel) const {
    return {.robot = robot,
            .octets = encoded_for_loop(control::Ask{.channel = channel, .asker = self_})};
}

std::vector<LoopStop::ToRobot> LoopStop::on_answer(Instant now, Bytes data) {
    const auto message = control::decode(data);
    const auto* report = message ? std::get_if<control::Report>(&*message) : nullptr;
    if (report == nullptr) return {};
    const auto begun = begun_.find(report->plant);
    if (begun == begun_.end() || now - begun->second > answers_within) return {};
    if (report->reason == control::Reason::no_such_channel) return {};
    std::vector<ToRobot> out;
    if (report->state != control::State::free) {
        // Its end is told, and then the next channel is asked for.
        out.push_back(
            {.robot = report->plant,
             .octets = encoded_for_loop(control::End{.session = report->session, .asker = self_})});
        return out;
    }
    const unsigned next = static_cast<unsigned>(report->channel) + 1;
    if (next < most_channels) {
        out.push_back(ask(report->plant, control::Channel{static_cast<std::uint8_t>(next)}));
    }
    return out;
}

}  // namespace romano::experiments
