// A broker without a cluster, as `romano-broker` runs it without --domain: the broker core alone.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "broker/core/broker_core.h"
#include "overlay/sim/broker_process.h"

namespace romano::sim {

struct LoneBrokerOptions {
    std::string name;
    Node node{};
    std::vector<Endpoint> addresses;
    broker::BrokerOptions broker;
    std::vector<std::pair<std::string, std::string>> system_topics{};  // and what they say
};

class LoneBroker final : public BrokerProcess {
public:
    LoneBroker(const LoneBrokerOptions& options, EventQueue& events, ClientNetwork& clients,
               Trace& trace, std::uint64_t seed);

    /// While up.
    [[nodiscard]] const broker::BrokerCore& core() const { return *core_; }

private:
    void create_core() override;
    void destroy_core() override { core_.reset(); }
    void take(const Datagram& datagram) override;
    void take(const cluster::Envelope&) override {}
    void tick() override;
    [[nodiscard]] Instant next_wakeup() const override { return core_->next_wakeup(); }
    void carry_out();

    LoneBrokerOptions options_;
    std::uint64_t seed_;
    std::unique_ptr<broker::BrokerCore> core_;
    broker::Actions actions_;
};

}  // namespace romano::sim
