// What goes over the uplink and what comes in over it: decides, without I/O.
//
// Every broker of the network has one. The leader's holds the link; the others only remember what
// came in, so that the next leader knows it. What shall go out waits in a session of the cluster,
// which its owner brings to the leader (BrokerOptions::read_by_owner); here is only the window of
// those that are on their way.
//
// Each message has an identity that travels with it: "NETWORK/LOG/SEQ" for what this network's
// clients published, so that another network takes it once however often it comes; a repetition of
// what anybody else published is known by the MQTT session, its packet id and its contents. The
// MQTT broker uses an id again as soon as it is answered, and repeats nothing within a connection
// (MQTT 5, 4.4): only what comes first under an id may be a repetition, and only of what came last
// under it.
#pragma once

#include <bitset>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "broker/core/session_image.h"
#include "broker/uplink/seen_identities.h"
#include "broker/uplink/topic_rules.h"

namespace romano::uplink {

struct UplinkOptions {
    std::string network;  // the same at all its brokers, different from other networks
    std::vector<TopicRule> rules;
    std::string session = "romano-uplink";  // the client id under which waits what goes out
    /// Of QoS 2 a message leaves its session, safely, before it is sent: when the leader dies then,
    /// it may be lost and is never sent twice. For links whose other end knows no identities.
    bool takes_before_sending = false;
    /// What is retained on these is sent whenever the link comes up: its other end keeps nothing
    /// when a leader dies.
    std::vector<std::string> retained_filters = {};
};

/// To the MQTT broker.
struct PublishUp {
    broker::MessagePtr message;
    std::string topic;
    mqttsn::Qos qos;
    std::string identity;
};
struct OpenLink {};
struct CloseLink {};
/// What came with this token is safe: the MQTT broker may hear so.
struct Acknowledge {
    std::uint64_t token;
};
/// It waited here, but no rule sends it any more.
struct Discard {
    broker::LogPosition position;
};
using UplinkAction = std::variant<OpenLink, CloseLink, PublishUp, Acknowledge, Discard>;

/// From the MQTT broker.
struct FromRemote {
    std::string topic;
    std::vector<std::uint8_t> payload;
    mqttsn::Qos qos = mqttsn::Qos::at_most_once;  // as its publisher said, if known
    bool retain = false;
    std::string identity;       // empty: its publisher is no ROMANO network
    std::uint16_t packet_id{};  // 0 at QoS 0
};

/// What the MQTT broker says of a message of QoS 1 or 2.
enum class Answer : std::uint8_t {
    done,  // it has the message, or never will
    busy,  // it does not take the message now
};

/// What the shell that holds the link tells.
struct LinkEvents {
    std::function<void(bool resumed)> on_up;
    std::function<void()> on_down;
    std::function<void(const broker::LogPosition&, Answer)> on_answer;
    std::function<void(const FromRemote&, std::uint64_t token)> on_message;
};

/// To be published here.
struct Inbound {
    Place place;
    std::string origin;
};

struct UplinkCounters {
    std::uint64_t sent = 0;
    std::uint64_t confirmed = 0;  // of QoS 1 and 2: done
    std::uint64_t received = 0;
    std::uint64_t busy = 0;        // not taken, to be sent again
    std::uint64_t duplicates = 0;  // came in again
    std::uint64_t own = 0;         // came back
    std::uint64_t unwanted = 0;    // fits no rule, or cannot be published here
    std::uint64_t dropped = 0;     // QoS 0 while the link was down
};

class UplinkCore {
public:
    /// So many messages of QoS 1 and 2 are on their way at a time.
    static constexpr std::size_t window = 64;
    static constexpr std::size_t longest_identity = 128;
    static constexpr std::size_t packet_ids = 65'536;

    /// `unique` differs between all lives of all brokers.
    UplinkCore(const UplinkOptions& options, std::uint64_t unique);

    [[nodiscard]] const TopicRules& rules() const { return rules_; }
    [[nodiscard]] bool holds_link() const { return holds_; }
    [[nodiscard]] bool is_up() const { return up_; }
    [[nodiscard]] const UplinkCounters& counters() const { return counters_; }

    void hold(bool holds, std::vector<UplinkAction>& out);
    /// `resumed`: the MQTT broker still has the session of this network's last link.
    void on_up(bool resumed);
    void on_down() { up_ = false; }

    /// Sends what waits, as far as the window goes. `safe`: what was published here up to there is
    /// held by enough peers.
    void send(std::span<const broker::Delivery> waiting, const broker::LogPosition& safe,
              std::vector<UplinkAction>& out);
    /// A message of QoS 0: now or never.
    void send_now(const broker::MessagePtr& message, std::vector<UplinkAction>& out);
    /// What is retained here, unless it waits or came in. The link's answer changes nothing.
    void send_retained(std::span<const broker::MessagePtr> retained,
                       std::span<const broker::Delivery> waiting, std::vector<UplinkAction>& out);
    /// What is not taken is sent again when all others that are on their way are answered.
    void on_answer(const broker::LogPosition& position, Answer answer);

    /// Empty when it shall not be published: known, our own, or not wanted.
    [[nodiscard]] std::optional<Inbound> receive(const FromRemote& message);
    /// Something with an origin was published, here or at a peer.
    void remember(const std::string& origin);

private:
    [[nodiscard]] std::string identity_of(const broker::LogPosition& position) const;
    /// Of a message whose publisher gave it none.
    [[nodiscard]] std::string identity_of(const FromRemote& message) const;
    void begin_mqtt_session(std::string name);
    /// Of a message without an identity that has come already.
    void note_newest(std::string_view packet);
    [[nodiscard]] bool is_newest(const FromRemote& message) const;

    std::string network_;
    TopicRules rules_;
    bool holds_ = false;
    bool up_ = false;
    std::string mqtt_session_;  // names the session at the MQTT broker, across leaders
    std::uint64_t unique_;
    std::uint64_t counted_ = 0;
    std::vector<broker::LogPosition> on_their_way_;
    bool is_busy_ = false;  // the MQTT broker, since one of them came back
    SeenIdentities seen_;
    std::bitset<packet_ids> came_;       // since the link is up
    std::vector<std::uint64_t> newest_;  // by packet id: the digest of what came last; 0: nothing
    UplinkCounters counters_;
};

}  // namespace romano::uplink
