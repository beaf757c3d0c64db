#include "experiments/fleet/talks.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "experiments/fleet/shown_text.h"
#include "romano/message/romano_id.h"

namespace romano::experiments {

bool Talk::on_second() {
    silent_s_ = now_ == 0 ? silent_s_ + 1 : 0;
    const std::uint32_t last = std::exchange(now_, 0);
    const std::uint32_t gone = std::exchange(before_[next_], last);
    next_ = (next_ + 1) % seconds;
    return gone != last;
}

double Talk::messages_per_s() const {
    return std::accumulate(before_.begin(), before_.end(), 0.0) / static_cast<double>(seconds);
}

bool Talks::on_message(std::string_view from, std::string_view topic, std::string_view to) {
    TalkEnds ends{std::string{from}, std::string{topic}, std::string{to}};
    const auto found = all_.find(ends);
    if (found != all_.end()) {
        found->second.on_message();
        return true;
    }
    if (all_.size() >= most) return false;
    all_[std::move(ends)].on_message();
    return true;
}

bool Talks::on_second() {
    bool changed = false;
    for (auto& [ends, talk] : all_) changed = talk.on_second() || changed;
    const auto forgotten = std::erase_if(
        all_, [](const auto& one) { return one.second.silent_s() >= forgotten_after_s; });
    return changed || forgotten > 0;
}

std::string shown_topic(std::string_view topic) {
    if (topic.size() > most_shown_octets) return shown_text(topic);
    std::string out;
    for (std::string_view rest = topic;;) {
        const std::size_t end = std::min(rest.find('/'), rest.size());
        const std::string_view level = rest.substr(0, end);
        out += message::RomanoId::parse(level) ? "{id}" : level;
        if (end == rest.size()) return out;
        out += '/';
        rest.remove_prefix(end + 1);
    }
}

}  // namespace romano::experiments
