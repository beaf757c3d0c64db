#include "experiments/sweep/fault_injection.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <numeric>
#include <utility>

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;

constexpr auto ends_within = 5s;  // after SIGTERM

bool never_done() {
    return false;
}

}  // namespace

FaultInjection::FaultInjection(const SweepSettings& settings, const Cell& cell,
                               CellBrokers& brokers, std::ofstream notes, RunUntil run_until)
    : settings_(settings),
      cell_(cell),
      brokers_(brokers),
      world_(brokers.world()),
      notes_(std::move(notes)),
      run_until_(std::move(run_until)),
      random_(cell.seed * 1'000'003 + cell.repetition + 2) {}

void FaultInjection::run(Instant end) {
    switch (cell_.fault) {
        case Fault::none:
            return;
        case Fault::kill_leader:
            return kill(leader());
        case Fault::kill_home:
            return kill(another_than_the_leader());
        case Fault::pause:
            return pause(another_than_the_leader(), end);
        case Fault::pause_leader:
            return pause(leader(), end);
        case Fault::cut:
            return cut(another_than_the_leader(), end);
        case Fault::all_but_one:
            return kill_all_but_one(end);
        case Fault::rolling_restart:
        case Fault::rolling_kill:
            return replace_one_after_the_other(end);
    }
}

void FaultInjection::kill(std::size_t broker) {
    strike(broker, "kill -9");
    brokers_.kill(broker);
}

void FaultInjection::pause(std::size_t broker, Instant end) {
    strike(broker, "SIGSTOP");
    world_.pause(broker);
    rest(end);
    note(world_.now(), "SIGCONT " + brokers_[broker].name);
    world_.resume(broker);
}

void FaultInjection::cut(std::size_t broker, Instant end) {
    strike(broker, "cuts off");
    world_.cut(broker);
    rest(end);
    note(world_.now(), "mends the link of " + brokers_[broker].name);
    world_.mend(broker);
}

void FaultInjection::kill_all_but_one(Instant end) {
    auto order = in_any_order();
    order.pop_back();
    for (const std::size_t broker : order) {
        kill(broker);
        rest(end);
    }
}

void FaultInjection::replace_one_after_the_other(Instant end) {
    const auto order = in_any_order();
    for (std::size_t turn = 0; world_.now() < end; ++turn) {
        const std::size_t broker = order[turn % order.size()];
        if (cell_.fault == Fault::rolling_kill) {
            kill(broker);
        } else {
            const Instant asked = strike(broker, "SIGTERM");
            brokers_.ask_to_stop(broker);
            if (!run_until_(asked + ends_within, [&] { return world_.has_ended(broker); })) {
                throw RunFailed(brokers_[broker].name + " did not end within 5 s of SIGTERM");
            }
        }
        note(world_.now(), "starts " + brokers_[broker].name);
        brokers_.start(broker);
        await_whole();
        note(world_.now(), "all are in one view, each at its own address");
        rest(end);
    }
}

std::size_t FaultInjection::leader() const {
    const auto leader = brokers_.leader();
    if (!leader) throw RunFailed("nobody led when the fault was due");
    return *leader;
}

std::size_t FaultInjection::another_than_the_leader() {
    const auto others = static_cast<std::uint32_t>(brokers_.size() - 1);
    return (leader() + 1 + random_.below(others)) % brokers_.size();
}

std::vector<std::size_t> FaultInjection::in_any_order() {
    std::vector<std::size_t> order(brokers_.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    for (std::size_t left = order.size(); left > 1; --left) {
        std::swap(order[left - 1], order[random_.below(static_cast<std::uint32_t>(left))]);
    }
    return order;
}

Instant FaultInjection::strike(std::size_t broker, const char* what) {
    brokers_.end_usage(broker);
    const Instant at = world_.now();
    strikes_.push_back({broker, at});
    note(at, std::string{what} + " " + brokers_[broker].name);
    return at;
}

void FaultInjection::note(Instant at, const std::string& what) {
    std::array<char, 32> clock{};
    std::snprintf(clock.data(), clock.size(), "[%.6f] ",
                  std::chrono::duration<double>(at.time_since_epoch()).count());
    notes_ << clock.data() << what << std::endl;
}

void FaultInjection::rest(Instant end) {
    run_until_(std::min(end, world_.now() + std::chrono::duration_cast<Duration>(settings_.pause)),
               never_done);
}

void FaultInjection::await_whole() {
    const Instant deadline =
        world_.now() + std::chrono::duration_cast<Duration>(settings_.start_within);
    if (run_until_(deadline, [this] { return brokers_.are_whole(); })) return;
    throw RunFailed("the brokers were not whole again within start_within; " +
                    brokers_.what_they_see());
}

}  // namespace romano::experiments
