#include "experiments/fleet/time_line.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <utility>

namespace romano::experiments {
namespace {

constexpr std::chrono::seconds a_moment{3};
// A burst has few kinds of happenings; nobody looks through all for each of 10,000 robots.
constexpr std::size_t most_looked_back = 16;

constexpr std::array<std::string_view, 15> names = {
    "broker-found", "broker-died", "broker-back",  "leader",      "take-over",
    "hand-back",    "roam",        "robots-found", "robots-left", "robots-silent",
    "robots-away",  "robots-back", "watch-lost",   "watch-back",  "command"};

bool is_same(const Happening& before, const TimeLine::What& what) {
    return before.kind == what.kind && before.from == what.from && before.to == what.to &&
           before.what == what.what;
}

}  // namespace

std::string_view name_of(HappeningKind kind) {
    return names.at(static_cast<std::size_t>(kind));
}

void TimeLine::make_room(HappeningKind kind) {
    const auto is_same_kind = [kind](const Happening& one) { return one.kind == kind; };
    const bool is_frequent = kind >= HappeningKind::roam && kind != HappeningKind::watch_lost &&
                             kind != HappeningKind::watch_back;
    if (is_frequent && std::ranges::count_if(happenings_, is_same_kind) >=
                           std::ptrdiff_t{most_of_a_frequent_kind}) {
        happenings_.erase(std::ranges::find_if(happenings_, is_same_kind));
    }
    if (happenings_.size() >= most_happenings) happenings_.pop_front();
}

Happening& TimeLine::add(Instant now, std::uint64_t version, What what) {
    make_room(what.kind);
    Happening& added = happenings_.emplace_back();
    added.number = ++last_;
    added.changed = version;
    added.first = now;
    added.last = now;
    added.kind = what.kind;
    added.from = std::move(what.from);
    added.to = std::move(what.to);
    added.what = std::move(what.what);
    return added;
}

Happening& TimeLine::add(Instant now, std::uint64_t version, What what,
                         const message::RomanoId& robot) {
    Happening* joined = nullptr;
    std::size_t looked = 0;
    for (auto before = happenings_.rbegin();
         before != happenings_.rend() && looked < most_looked_back; ++before, ++looked) {
        if (now - before->last <= a_moment && is_same(*before, what)) {
            joined = &*before;
            break;
        }
    }
    if (joined == nullptr) joined = &add(now, version, std::move(what));
    joined->changed = version;
    joined->last = now;
    ++joined->robot_count;
    if (joined->robots.size() < most_robots_named) joined->robots.push_back(robot);
    return *joined;
}

Happening* TimeLine::find(std::uint64_t number) {
    const auto found = std::ranges::lower_bound(happenings_, number, {}, &Happening::number);
    return found != happenings_.end() && found->number == number ? &*found : nullptr;
}

}  // namespace romano::experiments
