#include "overlay/sim/broker_process.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "overlay/sim/seed.h"

namespace romano::sim {

using namespace std::chrono_literals;

namespace {
LocalClock some_clock(std::uint64_t seed, std::int64_t drift_ppm_max) {
    Random random(seed);
    const Duration offset = random.between(1s, 10h);
    const auto drifts = static_cast<std::uint32_t>(2 * drift_ppm_max + 1);
    return {offset, static_cast<std::int64_t>(random.below(drifts)) - drift_ppm_max};
}
}  // namespace

BrokerProcess::BrokerProcess(std::string name, Node node, EventQueue& events,
                             ClientNetwork& clients, Trace& trace, std::uint64_t seed,
                             const Machine& machine)
    : events_(events),
      trace_(trace),
      random_(seed_of(seed, "process")),
      name_(std::move(name)),
      node_(node),
      clients_(clients),
      clock_(some_clock(seed_of(seed, "clock"), machine.drift_ppm_max)),
      turn_(machine.turn) {}

void BrokerProcess::start() {
    if (up_) return;
    up_ = true;
    ++incarnation_;
    timer_ = never;
    trace_.note(events_.now(), name_, "starts", incarnation_);
    create_core();
    rearm();
}

void BrokerProcess::crash() {
    if (!up_) return;
    trace_.note(events_.now(), name_, "crashes");
    up_ = false;
    stopped_ = false;
    for (const auto& [address, binding] : std::exchange(bound_, {})) clients_.unbind(binding);
    datagrams_.clear();
    envelopes_.clear();
    postponed_.clear();
    on_go_on();
    destroy_core();
}

void BrokerProcess::stop() {
    if (!is_running()) return;
    trace_.note(events_.now(), name_, "is stopped");
    stopped_ = true;
    on_stop();
}

void BrokerProcess::stop_core() {
    if (!is_running()) return;
    trace_.note(events_.now(), name_, "has a core that stands still");
    stopped_ = true;
    on_stop_core();
}

void BrokerProcess::go_on() {
    if (!up_ || !stopped_) return;
    trace_.note(events_.now(), name_, "goes on");
    stopped_ = false;
    on_go_on();
    run_backlog();
}

void BrokerProcess::run_backlog() {
    auto envelopes = std::exchange(envelopes_, {});
    auto postponed = std::exchange(postponed_, {});
    std::size_t envelope = 0;
    bool ticked = false;
    while (is_running()) {
        const bool more = !datagrams_.empty() || envelope < envelopes.size() || !ticked;
        if (!more) break;
        switch (random_.below(3)) {
            case 0:
                if (!datagrams_.empty()) {
                    const Datagram datagram = std::move(datagrams_.front());
                    datagrams_.pop_front();
                    take(datagram);
                }
                break;
            case 1:
                if (envelope < envelopes.size()) take(envelopes[envelope++]);
                break;
            default:
                if (!std::exchange(ticked, true)) tick();
                break;
        }
    }
    for (const auto& action : postponed) {
        if (is_running()) action();
    }
    rearm();
}

void BrokerProcess::bind(const Endpoint& address) {
    const auto former = bound_.extract(address);  // what came there is read yet
    if (!former.empty()) clients_.unbind(former.mapped());
    const auto receive = [this](const Endpoint& at, const Endpoint& from, Bytes octets) {
        Datagram datagram{at, from, {octets.begin(), octets.end()}};
        if (!stopped_) {
            take(datagram);
            rearm();
        } else if (datagrams_.size() < socket_buffer) {
            datagrams_.push_back(std::move(datagram));
        }
    };
    bound_.emplace(address, clients_.bind(address, node_, receive));
}

void BrokerProcess::unbind(const Endpoint& address) {
    const auto found = bound_.find(address);
    if (found == bound_.end()) return;
    clients_.unbind(found->second);
    bound_.erase(found);
    std::erase_if(datagrams_, [&](const Datagram& unread) { return unread.via == address; });
}

void BrokerProcess::send(const Endpoint& via, const Endpoint& to, Bytes datagram) {
    if (bound_.contains(via)) clients_.send(node_, via, to, datagram);  // else it has no socket
}

void BrokerProcess::on_envelope(const cluster::Envelope& envelope) {
    if (!stopped_) {
        take(envelope);
        rearm();
        return;
    }
    const bool best_effort =
        cluster::delivery_of(envelope.message) == cluster::Delivery::beacon ||
        cluster::delivery_of(envelope.message) == cluster::Delivery::best_effort;
    if (!best_effort || envelopes_.size() < socket_buffer) {
        envelopes_.push_back(envelope);
    }
}

void BrokerProcess::later(Duration delay, EventQueue::Event action) {
    events_.after(delay, [this, born = incarnation_, action = std::move(action)] {
        if (!up_ || incarnation_ != born) return;
        if (stopped_) {
            postponed_.push_back(action);
            return;
        }
        action();
        rearm();
    });
}

void BrokerProcess::rearm() {
    if (!is_running()) return;
    const Instant at_once = ticked_at_ == events_.now() ? ticked_at_ + turn_ : events_.now();
    const Instant wanted = std::max(clock_.when(next_wakeup()), at_once);
    if (wanted == never || wanted >= timer_) return;
    timer_ = wanted;
    events_.at(wanted, [this, wanted, born = incarnation_] {
        if (timer_ != wanted || incarnation_ != born) return;
        timer_ = never;
        if (!is_running()) return;
        ticked_at_ = wanted;
        tick();
        rearm();
    });
}

}  // namespace romano::sim
