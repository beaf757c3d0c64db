#include "experiments/recording/playback.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "experiments/fleet/picture_feed.h"
#include "experiments/recording/left_out_text.h"
#include "experiments/recording/recorded_message.h"

namespace romano::experiments {
namespace {

using mcap::Timestamp;

constexpr Timestamp ns_per_ms = 1'000'000;
constexpr Timestamp tick_every = 100 * ns_per_ms;
// A picture remembers no longer than that; a gap of years is no work.
constexpr Timestamp longest_ticking = 400'000 * ns_per_ms;

// Of one on_tick(): about 20 ms of work. What is passed over costs little.
constexpr int most_told = 4'000;
constexpr int passed_over_for_one_told = 20;

Instant instant_of(Timestamp time) {
    return Instant{Duration{static_cast<std::int64_t>(time)}};
}

}  // namespace

Playback::Playback(mcap::Reader& reader, std::string file, FleetPicture& picture)
    : reader_(reader), file_(std::move(file)), picture_(picture) {
    begin();
}

void Playback::begin() {
    picture_ = FleetPicture{Duration{0}, {}, picture_.version() + 1};
    picture_.on_link(instant_of(reader_.start()), true);
    reader_.seek(reader_.start());
    ahead_ = reader_.next();
    at_ = reader_.start();
    next_tick_ = at_;
    show();
}

void Playback::play() {
    if (at_ >= reader_.end() && !target_) begin();
    is_playing_ = true;
    show();
}

void Playback::pause() {
    is_playing_ = false;
    show();
}

void Playback::set_speed(double speed) {
    speed_ = std::clamp(speed, slowest, fastest);
    show();
}

void Playback::seek(std::uint64_t unix_ms) {
    const Timestamp last_ms = reader_.end() / ns_per_ms;
    const Timestamp time =
        std::clamp(std::min(unix_ms, last_ms + 1) * ns_per_ms, reader_.start(), reader_.end());
    if (time < at_) begin();
    target_ = time;
    show();
}

void Playback::on_tick(Instant now) {
    const Duration passed = now - std::exchange(last_tick_, now).value_or(now);
    if (target_) {
        if (tell_until(*target_)) target_.reset();
    } else if (is_playing_) {
        const double step = speed_ * static_cast<double>(passed.count());
        const Timestamp left = reader_.end() - at_;
        const Timestamp until =
            step < static_cast<double>(left) ? at_ + static_cast<Timestamp>(step) : reader_.end();
        (void)tell_until(until);
        if (at_ >= reader_.end()) is_playing_ = false;
    }
    show();
}

bool Playback::tell_until(Timestamp until) {
    const Timestamp remembered_ns = std::chrono::nanoseconds{remembered}.count();
    int work = 0;
    while (ahead_ && ahead_->time <= until) {
        if (work >= most_told * passed_over_for_one_told) {
            at_ = std::max(at_, std::min(ahead_->time, until));
            return false;
        }
        const bool is_state =
            ahead_->channel->topic.starts_with('$') || ahead_->channel->topic == recorder_topic;
        if (is_state || until - ahead_->time < remembered_ns) {
            tell(*ahead_);
            work += passed_over_for_one_told;
        } else {
            ++work;
        }
        ahead_ = reader_.next();
    }
    tick_until(until);
    at_ = until;
    return true;
}

void Playback::tell(const mcap::Reader::Told& told) {
    const auto message = recorded_message(*told.channel, told.data);
    if (!message) return;
    tick_until(told.time);
    const Instant now = instant_of(told.time);
    if (message->kind == recorder_kind) return picture_.on_link(now, message->is_linked);
    tell_picture(picture_, now, message->topic, as_octets(message->data));
}

void Playback::tick_until(Timestamp time) {
    if (time > longest_ticking) next_tick_ = std::max(next_tick_, time - longest_ticking);
    for (; next_tick_ <= time; next_tick_ += tick_every) picture_.on_tick(instant_of(next_tick_));
}

void Playback::show() {
    picture_.on_played({.file = file_,
                        .start_unix_ms = reader_.start() / ns_per_ms,
                        .end_unix_ms = reader_.end() / ns_per_ms,
                        .at_unix_ms = at_ / ns_per_ms,
                        .speed = speed_,
                        .is_playing = is_playing_,
                        .is_seeking = target_.has_value(),
                        .lost = sentences_about(reader_)});
}

}  // namespace romano::experiments
