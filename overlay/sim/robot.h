// A robot: the shipped client core, and an application that publishes numbered messages, subscribes
// and writes down in the ledger what it asked for, what was acknowledged and what it got.
//
// A conforming client. It talks to one address until it roams to another one, which it does not
// tell anybody; when the broker counts as lost or says DISCONNECT it connects again without clean
// session, and relies on its subscriptions being kept (and on its messages, when the session never
// was a clean one). Asleep, it publishes nothing.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "overlay/sim/client_network.h"
#include "overlay/sim/dtls_ends.h"
#include "overlay/sim/event_queue.h"
#include "overlay/sim/ledger.h"
#include "overlay/sim/sealed_packets.h"
#include "overlay/sim/trace.h"
#include "romano/base/endpoint.h"
#include "romano/base/random.h"
#include "romano/client/client.h"
#include "romano/protection/robot_end.h"
#include "romano/protection/skipped_blocks.h"

namespace romano::sim {

struct RobotOptions {
    struct Filter {
        std::string filter;
        mqttsn::Qos qos = mqttsn::Qos::exactly_once;
    };

    std::string name;
    Endpoint address;  // its own
    Endpoint broker;
    Endpoint cell_group;  // listens there to what its broker sends once for many; or family none
    Node node{};
    std::vector<Filter> subscriptions;
    std::vector<std::string> topics;  // that it publishes on, in random order
    std::vector<mqttsn::Qos> qos{mqttsn::Qos::exactly_once};
    Duration publish_every_min{std::chrono::milliseconds{50}};
    Duration publish_every_max{std::chrono::milliseconds{150}};
    std::uint32_t retain_ppm = 0;
    bool clean_session = true;  // of its first CONNECT
    std::chrono::seconds keep_alive{60};
    std::optional<std::string> will_topic;  // will at QoS 2
    SealedPackets* sealed = nullptr;        // of a world whose robots are protected
    DtlsRecords* dtls = nullptr;            // of one whose robots speak DTLS
    bool has_id = false;                    // a Connection ID: its own address changes, too
    client::Timing timing{
        .t_retry = std::chrono::milliseconds{500}, .t_wait = std::chrono::seconds{1}, .n_retry = 5};
};

class Robot {
public:
    Robot(const RobotOptions& options, EventQueue& events, ClientNetwork& network, Trace& trace,
          Ledger& ledger, std::uint64_t seed);
    ~Robot();
    Robot(const Robot&) = delete;
    Robot& operator=(const Robot&) = delete;

    void start();
    /// Publishes from now on by itself, or no more.
    void begin_publishing();
    void end_publishing();
    /// Publishes now; empty when the client's queue is full.
    std::optional<std::uint32_t> publish(const std::string& topic, mqttsn::Qos qos,
                                         bool retain = false);
    void subscribe(const std::string& filter, mqttsn::Qos qos);
    void unsubscribe(const std::string& filter);
    /// Falls silent without a word, for good.
    void switch_off();
    /// From now on it is in reach of another broker, and goes on as if nothing had happened.
    void roam_to(const Endpoint& broker);
    /// Says so, and collects its messages within each `duration` until it comes back.
    void fall_asleep(std::chrono::seconds duration);
    void come_back();

    [[nodiscard]] const RobotOptions& options() const { return options_; }
    [[nodiscard]] const std::string& name() const { return options_.name; }
    [[nodiscard]] bool is_on() const { return on_; }
    /// As it believes; one that is switched off believes nothing.
    [[nodiscard]] bool is_connected() const { return on_ && client_.is_connected(); }
    [[nodiscard]] bool is_sleeping() const;
    /// Connected, subscribed to everything, and nothing waits for the broker.
    [[nodiscard]] bool is_idle() const { return is_connected() && client_.is_idle(); }
    /// CONNECTs asked for by the application; one, when it never noticed anything.
    [[nodiscard]] std::uint32_t connects() const { return connects_; }
    [[nodiscard]] std::uint32_t published() const { return last_number_; }

private:
    /// What an operation of the client stands for.
    struct Subscribing {
        std::string filter;
    };
    using Asked = std::variant<std::uint32_t, Subscribing>;

    [[nodiscard]] bool listens() const {
        return options_.cell_group.family != Endpoint::Family::none;
    }
    void connect(bool clean);
    void listen();
    void bind();
    void change_address();
    void put(Bytes datagram) {
        network_.send(options_.node, options_.address, options_.broker, datagram);
    }
    void on_datagram(Bytes datagram);
    [[nodiscard]] std::vector<std::uint8_t> seal(Bytes message);
    void on_timer();
    void rearm();
    void drain();
    void on_event(const client::Event& event);
    void on_received(const client::Received& received);
    void on_published(client::OperationId operation, bool accepted);
    void on_subscribed(const client::Subscribed& subscribed);
    void connect_again();
    void lapse();
    void publish_next();
    void end_spans(const std::string* filter);

    RobotOptions options_;
    EventQueue& events_;
    ClientNetwork& network_;
    Trace& trace_;
    Ledger& ledger_;
    Random random_;
    client::Client<> client_;
    client::OutputFor<> out_;
    /// Of a protected robot. Its flash is new: each life has a name and a key of its own.
    struct Protection {
        explicit Protection(const std::string& name)
            : keys(protection::direction_keys(SealedPackets::key_of(name))), end(keys, name, 0) {}
        const protection::DirectionKeys keys;
        protection::RobotEnd end;
        protection::SkippedBlocks skipped;
    };
    std::unique_ptr<Protection> protection_;
    std::optional<DtlsRobotEnd> dtls_;
    Random moves_;      // to other addresses of its own
    std::string will_;  // what the client sends when asked for it
    ClientNetwork::Binding binding_{};
    std::map<client::OperationId, Asked> asked_;
    std::vector<SubscriptionSpan> lapsed_;  // to be had again when connected
    bool on_ = false;
    bool subscribed_ = false;
    bool publishing_ = false;
    bool reconnect_pending_ = false;
    std::uint32_t connects_ = 0;
    Instant connecting_since_{};
    std::uint32_t last_number_ = 0;
    Instant timer_ = never;
};

}  // namespace romano::sim
