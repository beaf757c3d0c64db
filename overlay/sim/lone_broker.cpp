#include "overlay/sim/lone_broker.h"

#include <variant>

#include "overlay/sim/seed.h"

namespace romano::sim {

LoneBroker::LoneBroker(const LoneBrokerOptions& options, EventQueue& events, ClientNetwork& clients,
                       Trace& trace, std::uint64_t seed)
    : BrokerProcess(options.name, options.node, events, clients, trace, seed),
      options_(options),
      seed_(seed) {}

void LoneBroker::create_core() {
    core_ = std::make_unique<broker::BrokerCore>(options_.broker,
                                                 seed_of(seed_, "core", incarnation()));
    for (const Endpoint& address : options_.addresses) bind(address);
    for (const auto& [topic, text] : options_.system_topics) {
        core_->set_system_topic(local_now(), topic, as_octets(text), actions_);
    }
    carry_out();
}

void LoneBroker::take(const Datagram& datagram) {
    core_->on_datagram(local_now(), datagram.via, datagram.from, datagram.octets, actions_);
    carry_out();
}

void LoneBroker::tick() {
    core_->on_tick(local_now(), actions_);
    carry_out();
}

void LoneBroker::carry_out() {
    for (const broker::Action& action : actions_.list()) {
        if (const auto* out = std::get_if<broker::Send>(&action)) {
            send(out->via, out->to.endpoint, actions_.octets(*out));
        }
    }
    actions_.clear();
    core_->check_invariants();
}

}  // namespace romano::sim
