#include "broker/daemon/persistence.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <utility>
#include <variant>

#include "broker/daemon/refusal.h"
#include "broker/net/clock.h"

namespace romano::daemon {
namespace {

constexpr auto retry_every = std::chrono::seconds{2};

[[noreturn]] void refuse(const std::string& path, const store::StoreRefusal& why) {
    throw Refusal("--store '" + path + "': " + why.what());
}

store::SessionStore open(const StoreSettings& settings) {
    try {
        return store::SessionStore({.path = settings.path,
                                    .most_octets = settings.most_octets,
                                    .survives_power_cut = settings.survives_power_cut});
    } catch (const store::StoreRefusal& why) {
        refuse(settings.path, why);
    }
}

bool waits(const broker::Action& action, broker::Seq kept) {
    const auto* send = std::get_if<broker::Send>(&action);
    return send != nullptr && send->after > kept;
}

/// Leaves out what waits for an event after `kept`, and the events themselves.
broker::Actions only_what_is_safe(const broker::Actions& actions, broker::Seq kept) {
    broker::Actions safe;
    for (const broker::Action& action : actions.list()) {
        if (waits(action, kept)) continue;
        if (const auto* send = std::get_if<broker::Send>(&action)) {
            safe.push(*send, actions.octets(*send));
        } else if (const auto* multicast = std::get_if<broker::Multicast>(&action)) {
            safe.push(*multicast, actions.octets(*multicast));
        }
    }
    return safe;
}

}  // namespace

Persistence::Persistence(boost::asio::io_context& io, const StoreSettings& settings)
    : path_(settings.path), store_(open(settings)), retry_(io, [this] { try_again(); }) {}

std::uint64_t Persistence::next_incarnation(std::uint64_t wall_clock) {
    try {
        return std::max(wall_clock, store_.last_incarnation() + 1);
    } catch (const store::StoreRefusal& why) {
        refuse(path_, why);
    }
}

void Persistence::restore(Instant now, broker::BrokerCore& core, const broker::LogId& log,
                          broker::Actions& out) {
    core_ = &core;
    try {
        store::StoredState state = store_.load(log.broker);
        for (const auto& message : state.retained) core.put_retained(message);
        spdlog::info("{}: {} sessions and {} retained messages go on", path_, state.sessions.size(),
                     state.retained.size());
        for (auto& image : state.sessions) core.adopt(now, std::move(image), {}, out);
    } catch (const store::StoreRefusal& why) {
        refuse(path_, why);
    }
    store_.begin_log(log);
    keep(core, out);
    if (!is_keeping_) throw Refusal("--store '" + path_ + "': " + store_.problem());
}

void Persistence::keep(broker::BrokerCore& core, broker::Actions& actions) {
    if (is_keeping_ && store_.keep(actions)) {
        kept_through_ = core.last_seq();
        ++batches_;
        return;
    }
    if (is_keeping_) suspend(core);
    const bool drops = std::ranges::any_of(
        actions.list(), [this](const auto& action) { return waits(action, kept_through_); });
    if (drops) core.on_output_dropped(kept_through_);  // so that its clients hear what comes later
    actions = only_what_is_safe(actions, kept_through_);
}

void Persistence::suspend(broker::BrokerCore& core) {
    spdlog::error(
        "{} {}; until then clients that ask for QoS 1, QoS 2, a session or a "
        "subscription hear \"congestion\"",
        path_, store_.problem());
    is_keeping_ = false;
    ++failures_;
    core.set_congested(true);
    retry_.arm(net::now() + retry_every);
}

void Persistence::add_metrics(metrics::Page& page) const {
    page.gauge("romano_store_writable", "0 while the store cannot be written.",
               is_keeping_ ? 1 : 0);
    page.counter("romano_store_batches_total", "Batches of datagrams that were kept.", batches_);
    page.counter("romano_store_failures_total", "Times that the store could not be written.",
                 failures_);
}

void Persistence::try_again() {
    if (!store_.keep_all(*core_)) {
        retry_.arm(net::now() + retry_every);
        return;
    }
    spdlog::info("{} can be written again", path_);
    kept_through_ = core_->last_seq();
    is_keeping_ = true;
    core_->set_congested(false);
}

}  // namespace romano::daemon
