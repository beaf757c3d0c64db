// The uplink as a member of a cluster carries it: joins the uplink core to the broker core.
//
// What shall go out waits in a session like any robot's: logged, mirrored, bounded, inherited. Only
// it is at no address: the leader's member connects it here, in the name of owner_endpoint, and
// reads its queue. A new leader does the same, and the session comes with what still waits.
#pragma once

#include <algorithm>
#include <deque>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "broker/core/broker_core.h"
#include "broker/uplink/uplink_core.h"
#include "overlay/cluster/cluster_core.h"
#include "overlay/member/member_facts.h"
#include "romano/base/time.h"

namespace romano::overlay {

class CarriedUplink {
public:
    CarriedUplink(const uplink::UplinkOptions& options, std::uint64_t unique)
        : client_id_(options.session),
          takes_before_sending_(options.takes_before_sending),
          retained_filters_(options.retained_filters),
          core_(options, unique) {}

    [[nodiscard]] const uplink::UplinkCore& core() const { return core_; }
    /// What comes over the link is for us.
    [[nodiscard]] bool takes_in() const { return leads_ && core_.holds_link(); }
    [[nodiscard]] UplinkFacts facts() const {
        return {.is_up = core_.is_up(), .counters = core_.counters(), .too_long = too_long_};
    }

    /// What its session must say to the broker now: datagrams from owner_endpoint.
    [[nodiscard]] std::vector<std::vector<std::uint8_t>> requests(
        Instant now, const broker::BrokerCore& broker, const cluster::ClusterCore& cluster,
        std::vector<uplink::UplinkAction>& out);

    /// The link is let go: sessions and log are gone to others.
    void abandon(std::vector<uplink::UplinkAction>& out) {
        let_go(out);
        confirmed_ = 0;
    }

    void on_up(bool resumed, const broker::BrokerCore& broker,
               std::vector<uplink::UplinkAction>& out) {
        core_.on_up(resumed);
        if (!core_.is_up()) return;
        for (const std::string& filter : retained_filters_) {
            core_.send_retained(broker.retained(filter), broker.unread(), out);
        }
    }
    void on_down() { core_.on_down(); }
    void on_answer(Instant now, const broker::LogPosition& position, uplink::Answer answer,
                   broker::BrokerCore& broker, broker::Actions& actions);
    void on_message(Instant now, const cluster::Times& times, const uplink::FromRemote& message,
                    std::uint64_t token, broker::BrokerCore& broker, broker::Actions& actions,
                    std::vector<cluster::LocalAction>& local);
    void on_for_owner(const broker::MessagePtr& message, std::vector<uplink::UplinkAction>& out);

    /// How far peers must know the own log soon: the MQTT broker waits for it, or the next leader
    /// would send what was confirmed.
    [[nodiscard]] broker::Seq awaits() const {
        return unsafe_.empty() ? confirmed_ : std::max(confirmed_, unsafe_.rbegin()->first);
    }
    /// Something is about to be sent, as soon as it is safe that its session has it no more.
    [[nodiscard]] bool has_taken() const { return !taken_.empty(); }
    /// Sends what may go, lets the MQTT broker know of what is safe. `own`: how far the own log is
    /// safe.
    void go_on(Instant now, const broker::LogPosition& own, broker::BrokerCore& broker,
               broker::Actions& actions, std::vector<uplink::UplinkAction>& out);

private:
    void let_go(std::vector<uplink::UplinkAction>& out) {
        core_.hold(false, out);
        unsafe_.clear();
        taken_.clear();
    }
    /// From `first` on: of QoS 2 they leave their session, and go when that is safe.
    void take(Instant now, std::size_t first, broker::BrokerCore& broker, broker::Actions& actions,
              std::vector<uplink::UplinkAction>& out);
    void warn_of_long(Instant now, const cluster::Times& times, const uplink::FromRemote& message,
                      std::size_t most, std::vector<cluster::LocalAction>& local);
    [[nodiscard]] bool may_connect(Instant now, const broker::BrokerCore& broker,
                                   const cluster::ClusterCore& cluster);
    [[nodiscard]] std::vector<std::vector<std::uint8_t>> missing_subscriptions(
        const broker::BrokerCore& broker) const;

    std::string client_id_;
    bool takes_before_sending_;
    std::vector<std::string> retained_filters_;
    uplink::UplinkCore core_;
    cluster::ViewNumber view_;
    Instant view_since_{};
    bool leads_ = false;
    Instant led_at_ = Instant::min();  // last
    Instant connect_again_at_ = Instant::min();
    bool is_subscribed_ = false;
    Instant subscribe_again_at_ = Instant::min();
    std::map<broker::Seq, std::vector<std::uint64_t>> unsafe_;  // tokens, by what they wait for
    std::uint64_t too_long_ = 0;                                // messages of the MQTT broker
    Instant warn_again_at_ = Instant::min();
    // What left its session, by the event that says so.
    std::deque<std::pair<broker::Seq, uplink::PublishUp>> taken_;
    broker::Seq confirmed_ = 0;  // says that the MQTT broker has a message
};

}  // namespace romano::overlay
