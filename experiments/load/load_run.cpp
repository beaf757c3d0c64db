#include "experiments/load/load_run.h"

#include <sys/resource.h>

#include <algorithm>
#include <utility>

#include "broker/net/clock.h"
#include "experiments/robots/stamp.h"

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;

constexpr LoadClients::Number joining_at_once = 64;
/// The next stream of a slot is far from its last one, so that what lies close together in a
/// broker's memory is not visited in turn. A prime.
constexpr std::uint64_t stride = 7919;

double in_seconds(Duration duration) {
    return std::chrono::duration<double>(duration).count();
}

double own_cpu_s() {
    rusage usage{};
    ::getrusage(RUSAGE_SELF, &usage);
    const auto seconds = [](const timeval& time) {
        return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) * 1e-6;
    };
    return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/// Behind the stamp stands the slot of the closed loop.
void write_slot(std::uint32_t slot, MutableBytes payload) {
    put_be16(payload, Stamp::octets, static_cast<std::uint16_t>(slot >> 16U));
    put_be16(payload, Stamp::octets + 2, static_cast<std::uint16_t>(slot));
}

std::uint32_t read_slot(Bytes payload) {
    return std::uint32_t{be16(payload, Stamp::octets)} << 16U | be16(payload, Stamp::octets + 2);
}

}  // namespace

LoadRun::LoadRun(const LoadPlan& plan, LoadClients& clients, LoadWatch watch)
    : plan_(plan),
      clients_(clients),
      watch_(std::move(watch)),
      arrivals_(plan.streams(), plan.receivers_of(0)),
      next_sequence_(plan.streams()),
      unanswered_(plan.publishers),
      payload_(plan.payload_octets) {
    clients_.attach(*this);
}

LoadFigures LoadRun::run() {
    join();
    load();
    drain();
    figures_.interrupted = is_stopped();
    figures_.all_delivered = arrivals_.delivered();
    figures_.duplicates = arrivals_.duplicates();
    figures_.out_of_order = arrivals_.out_of_order();
    for (const auto& open : unanswered_) figures_.unacknowledged += open.size();
    figures_.retransmissions = clients_.retransmissions();
    figures_.dropped_here = clients_.dropped_here();
    figures_.heard_in_cell = clients_.heard_in_cell();
    clients_.leave();
    return figures_;
}

void LoadRun::tell(const char* phase, double share) {
    if (watch_.on_progress) watch_.on_progress(phase, share);
}

/// One turn of the clients; now and then somebody hears how far we are.
void LoadRun::turn(Instant until) {
    if (watch_.on_turn) watch_.on_turn();
    clients_.turn(watch_.never_sleeps ? Instant{} : until);
}

// --- joining

void LoadRun::join() {
    const Instant began = net::now();
    while (joined_ < plan_.clients()) {
        while (begun_ < plan_.clients() && begun_ - joined_ < joining_at_once) {
            clients_.join(begun_++);
        }
        const Instant now = net::now();
        turn(now + 50ms);
        if (!trouble_.empty()) give_up(trouble_);
        if (is_stopped()) give_up("stopped before all clients had joined");
        tell("joining", static_cast<double>(joined_) / plan_.clients());
    }
    figures_.joined_s = in_seconds(net::now() - began);
}

/// The next load must not find this one's sessions at the broker.
void LoadRun::give_up(const std::string& why) {
    clients_.leave();
    throw LoadError(why);
}

void LoadRun::on_joined(Number) {
    ++joined_;
}

void LoadRun::on_trouble(Number, const std::string& why) {
    trouble_ = why;
    ++figures_.lost_clients;
}

// --- loading

void LoadRun::load() {
    loading_ = true;
    load_began_ = net::now();
    if (!plan_.rate_per_s) begin_loop();
    load_until(load_began_ + plan_.warm_up, "warming up");

    if (watch_.on_measuring) watch_.on_measuring();
    const double cpu_before = own_cpu_s();
    const std::uint64_t published_before = figures_.all_published;
    const std::uint64_t delivered_before = arrivals_.delivered();
    measured_from_ = net::now();
    measuring_ = true;
    load_until(measured_from_ + plan_.duration, "measuring");
    measuring_ = false;
    figures_.measured_s = in_seconds(net::now() - measured_from_);
    figures_.published = figures_.all_published - published_before;
    figures_.delivered = arrivals_.delivered() - delivered_before;
    figures_.generator_cpu_percent = 100 * (own_cpu_s() - cpu_before) / figures_.measured_s;
    if (watch_.on_measured) watch_.on_measured();
    loading_ = false;
}

void LoadRun::load_until(Instant until, const char* phase) {
    const Instant from = net::now();
    for (Instant now = from; now < until && !is_stopped(); now = net::now()) {
        Instant wake_at = std::min(until, now + 50ms);
        if (plan_.rate_per_s) {
            publish_due(now, until);
            const double next_s = static_cast<double>(scheduled_) / *plan_.rate_per_s;
            const auto next = std::chrono::duration<double>{next_s};
            wake_at = std::min(wake_at, load_began_ + std::chrono::duration_cast<Duration>(next));
        }
        turn(wake_at);
        if (now < looked_at_) continue;
        looked_at_ = now + 50ms;
        write_off(now);
        tell(phase, in_seconds(now - from) / in_seconds(until - from));
    }
    if (plan_.rate_per_s) publish_due(net::now(), until);  // what became due in the last turn
}

void LoadRun::publish_due(Instant now, Instant until) {
    for (;;) {
        const std::chrono::duration<double> at{static_cast<double>(scheduled_) / *plan_.rate_per_s};
        const Instant due = load_began_ + std::chrono::duration_cast<Duration>(at);
        if (due > now || due >= until) return;
        if (measuring_) figures_.worst_lag = std::max(figures_.worst_lag, now - due);
        publish(now, static_cast<std::uint32_t>(scheduled_++ % plan_.streams()), due, no_slot);
    }
}

void LoadRun::publish(Instant now, std::uint32_t stream, Instant due, std::uint32_t slot) {
    const std::uint32_t topic = plan_.topic_of(stream);
    const std::uint32_t publisher = plan_.publisher_of(stream);
    write_stamp({stream, next_sequence_[stream], due}, payload_);
    write_slot(slot, payload_);
    const auto begun = clients_.publish(now, publisher, topic, payload_);
    if (!begun) {
        ++figures_.not_taken;
        return;
    }
    ++next_sequence_[stream];
    ++figures_.all_published;
    figures_.expected += plan_.receivers_of(topic);
    if (plan_.qos != mqttsn::Qos::at_most_once) {
        unanswered_[publisher].push_back({*begun, slot, due});
    }
}

// --- the closed loop

void LoadRun::begin_loop() {
    slots_.resize(plan_.in_flight);
    for (std::uint32_t slot = 0; slot < slots_.size(); ++slot) {
        fill(load_began_, slot, static_cast<std::uint32_t>(slot * stride % plan_.streams()));
    }
}

void LoadRun::fill(Instant now, std::uint32_t slot, std::uint32_t stream) {
    const bool answered = plan_.qos != mqttsn::Qos::at_most_once;
    slots_[slot] = {stream, next_sequence_[stream],
                    plan_.receivers_of(plan_.topic_of(stream)) + (answered ? 1 : 0), now};
    publish(now, stream, now, slot);
    clients_.expect(plan_.publisher_of(stream_after(stream)));
}

/// The stream that a slot takes when its message has arrived.
std::uint32_t LoadRun::stream_after(std::uint32_t stream) const {
    return static_cast<std::uint32_t>((stream + plan_.in_flight * stride) % plan_.streams());
}

/// One of the things that a message on its way waited for has come.
void LoadRun::arrive(Instant now, std::uint32_t slot) {
    if (--slots_[slot].missing != 0 || !loading_) return;
    fill(now, slot, stream_after(slots_[slot].stream));
}

/// What was lost must not stop the loop.
void LoadRun::write_off(Instant now) {
    const Duration patience = plan_.qos == mqttsn::Qos::at_most_once ? 1s : 30s;
    for (std::uint32_t slot = 0; slot < slots_.size(); ++slot) {
        if (slots_[slot].missing == 0 || now - slots_[slot].sent_at < patience) continue;
        slots_[slot].missing = 1;
        arrive(now, slot);
    }
}

// --- what comes back

void LoadRun::on_message(Instant now, Number client, Bytes payload, bool again) {
    const auto stamp = read_stamp(payload);
    const bool whole = stamp && payload.size() == plan_.payload_octets &&
                       stamp->publisher < plan_.streams() && client >= plan_.publishers &&
                       stamp->sequence < next_sequence_[stamp->publisher];
    if (!whole) {
        ++figures_.strays;
        return;
    }
    const std::uint32_t stream = stamp->publisher;
    const std::uint32_t topic = plan_.topic_of(stream);
    const Number subscriber = client - plan_.publishers;
    const bool subscribed = plan_.topics >= plan_.subscribers
                                ? topic % plan_.subscribers == subscriber
                                : subscriber % plan_.topics == topic;
    if (!subscribed) {
        ++figures_.strays;
        return;
    }
    if (again) ++figures_.marked_dup;
    if (!arrivals_.note(stream, subscriber / plan_.topics, stamp->sequence)) return;
    if (measuring_ && stamp->sent_at >= measured_from_) {
        figures_.latency.add(now - stamp->sent_at);
        if (watch_.on_delivery)
            watch_.on_delivery(subscriber, stamp->sent_at, now - stamp->sent_at);
        if (arrivals_.receivers_having(stream, stamp->sequence) == plan_.receivers_of(topic)) {
            figures_.last_subscriber.add(now - stamp->sent_at);
        }
    }
    const std::uint32_t slot = read_slot(payload);
    if (slot < slots_.size() && slots_[slot].stream == stream &&
        slots_[slot].sequence == stamp->sequence) {
        arrive(now, slot);
    }
}

void LoadRun::on_published(Instant now, Number client, LoadClients::PublishId publish,
                           bool accepted) {
    auto& open = unanswered_[client];
    const auto found = std::ranges::find(open, publish, &Unanswered::publish);
    if (found == open.end()) return;
    const Unanswered answered = *found;
    open.erase(found);
    if (!accepted) ++figures_.refused;
    if (measuring_ && answered.due >= measured_from_) {
        figures_.acknowledgement.add(now - answered.due);
    }
    const bool on_its_way =
        answered.slot < slots_.size() && slots_[answered.slot].sent_at == answered.due;
    if (on_its_way) arrive(now, answered.slot);
}

// --- the end

bool LoadRun::is_settled() const {
    return arrivals_.delivered() >= figures_.expected &&
           std::ranges::all_of(unanswered_, [](const auto& open) { return open.empty(); });
}

void LoadRun::drain() {
    std::uint64_t arrived = arrivals_.delivered();
    Instant last = net::now();
    while (!is_settled() && !is_stopped()) {
        const Instant now = net::now();
        if (arrivals_.delivered() != arrived) last = now;
        arrived = arrivals_.delivered();
        if (now - last > plan_.drain) return;
        turn(now + 20ms);
        tell("waiting for the last messages", in_seconds(now - last) / in_seconds(plan_.drain));
    }
}

}  // namespace romano::experiments
