#include "broker/daemon/lone_broker.h"

#include <spdlog/spdlog.h>

#include <functional>
#include <nlohmann/json.hpp>

#include "broker/daemon/broker_options.h"
#include "broker/daemon/refusal.h"
#include "broker/daemon/service_addresses.h"
#include "broker/metrics/broker_metrics.h"
#include "broker/net/clock.h"
#include "broker/net/endpoint_text.h"

namespace romano::daemon {
namespace {

using namespace std::chrono_literals;

constexpr auto status_every = 1s;

// A batch of publishes that each fan out to thousands must not pile up in memory.
constexpr std::size_t most_actions_held = 4096;
constexpr std::size_t most_octets_held = std::size_t{1} << 20U;

}  // namespace

LoneBroker::LoneBroker(boost::asio::io_context& io, const Settings& settings,
                       const OnServing& on_serving)
    : io_(io),
      name_(settings.name),
      protection_(open_protection(settings)),
      rights_(settings.rights),
      options_(options_of(settings)),
      core_(options_, random_seed()),
      server_(settings.name, options_.unix_time_at_zero),
      udp_(io, *this),
      core_timer_(io, [this] { on_core_wakeup(); }),
      status_timer_(io, [this] { on_status_wakeup(); }),
      heap_limit_(settings.limits.memory_mib) {
    obey_rights();
    Serving serving;
    for (const Endpoint& address : settings.listen) {
        Endpoint bound;
        if (const auto error = udp_.open(address, net::Bind::alone, &bound)) {
            throw Refusal(why_not_served(address, error));
        }
        serving.addresses.push_back(bound);
    }
    join_discovery_groups(udp_, settings);
    if (persistence_) persistence_->restore(net::now(), core_, options_.log, actions_);
    on_core_wakeup();
    on_status_wakeup();
    on_serving(serving);
}

/// Opens the store, if there is one: it has a say in the number of this life.
broker::BrokerOptions LoneBroker::options_of(const Settings& settings) {
    broker::BrokerOptions options = broker_options(settings);
    if (!settings.store) return options;
    persistence_.emplace(io_, *settings.store);
    options.writes_log = true;
    options.log.incarnation = persistence_->next_incarnation(options.log.incarnation);
    return options;
}

void LoneBroker::on_datagram(const Endpoint& via, const Endpoint& from, Bytes octets) {
    if (protection_) {
        const auto take = [this](const dtls::Message& admitted) {
            on_message(admitted.path.via, admitted.path.from, admitted.octets);
        };
        protection_->admit(net::now(), via, from, octets, actions_, take);
    } else {
        on_message(via, from, octets);
    }
    if (actions_.list().size() >= most_actions_held || actions_.octets_held() >= most_octets_held) {
        send();
    }
}

void LoneBroker::on_message(const Endpoint& via, const Endpoint& from, Bytes message) {
    core_.on_datagram(net::now(), via, from, message, actions_);
    bad_senders_.look(core_.counters().malformed_total, from, message);
}

void LoneBroker::on_batch_end() {
    send();
    core_.set_full(heap_limit_.is_reached());
    core_timer_.arm(core_.next_wakeup());
}

void LoneBroker::on_core_wakeup() {
    core_.on_tick(net::now(), actions_);
    on_batch_end();
}

void LoneBroker::on_status_wakeup() {
    const bool are_keys_changed = protection_ && protection_->look();
    if (rights_.look(core_) || are_keys_changed) obey_rights();
    if (protection_) protection_->on_time(net::now(), actions_);
    publish_status();
    server_.on_tick(net::now(), core_, {}, actions_);
    on_batch_end();
    status_timer_.arm(net::now() + status_every);
}

void LoneBroker::obey_rights() {
    core_.set_permissions(rights_.for_owners_of_keys(protection_.get()));
}

void LoneBroker::read_rights_again() {
    rights_.read_again();
    obey_rights();
}

void LoneBroker::publish_status() {
    processor_load_.on_reading(net::now(), process_processor_time());
    nlohmann::json addresses = nlohmann::json::array();
    for (const Endpoint& address : udp_.addresses()) addresses.push_back(net::to_text(address));
    const std::string status =
        nlohmann::json{
            {"name", name_},
            {"alive", true},
            {"leader", true},
            {"rank", 0},
            {"sessions", core_.session_count()},
            {"connected", core_.connected_count()},
            {"addresses", std::move(addresses)},
            {"rights", rights_.digest()},
            {"view", {{"term", 0}, {"leader", name_}, {"count", 1}, {"members", {name_}}}},
            {"incarnation", options_.log.incarnation},
            {"longest_turn_us", std::chrono::duration_cast<std::chrono::microseconds>(
                                    net::TurnClock::of(io_).longest(net::now()))
                                    .count()},
            {"cpu_percent", processor_load_.percent()}}
            .dump();
    if (status == last_status_) return;
    last_status_ = status;
    core_.set_system_topic(net::now(), "$SYS/brokers/" + name_, as_octets(status), actions_);
    on_batch_end();
}

void LoneBroker::send() {
    server_.answer(net::now(), core_, actions_);
    for (const broker::Action& action : actions_.list()) {
        if (const auto* note = std::get_if<broker::Note>(&action)) spdlog::warn("{}", *note->text);
    }
    if (persistence_) persistence_->keep(core_, actions_);
    if (protection_) protection_->seal(actions_);
    udp_.carry_out(actions_);
    actions_.clear();
}

void LoneBroker::add_metrics(metrics::Page& page) const {
    metrics::add_messages(page, core_.counters());
    metrics::add_census(page, core_.census());
    metrics::add_datagrams(page, udp_.counters());
    heap_limit_.add_metrics(page);
    metrics::add_wakeups(page, core_timer_);
    metrics::add_turns(page, net::TurnClock::of(io_), net::now());
    if (persistence_) persistence_->add_metrics(page);
    if (protection_) protection_->add_metrics(page);
}

void LoneBroker::leave() {
    if (protection_) protection_->leave();
    io_.stop();
}

}  // namespace romano::daemon
