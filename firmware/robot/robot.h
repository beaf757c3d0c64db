// A robot's whole ROMANO side on a board: choice of the broker, MQTT-SN client, ROMANO node and
// mailbox, driven by one call, run(). C programs use romano.h, which is the same.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string_view>

#include "firmware/robot/board.h"
#include "firmware/robot/broker_choice.h"
#include "romano/client/client.h"
#include "romano/node/mailbox.h"
#include "romano/node/node.h"

namespace romano::firmware {

struct RobotSettings {
    node::NodeOptions node;
    Endpoint broker;  // family none: the nearest one that discovery finds
    client::Timing timing;
    std::uint64_t seed = 0;  // differs between robots
};

/// What the robot's own program is told, within run(). Answers may be published at once.
class Controller {
public:
    virtual void on_established() {}
    virtual void on_publish_request(std::string_view topic, Bytes kind_of_data) {
        (void)topic, (void)kind_of_data;
    }
    /// message::decode() reads it.
    virtual void on_message(std::string_view topic, Bytes message) { (void)topic, (void)message; }

protected:
    ~Controller() = default;
};

class RobotCore : private node::Port {
public:
    /// A broker that is talked to and says nothing for so long is asked whether it is there, so
    /// that the robot knows how strongly it hears it; who then says nothing for as long again is
    /// left for any other. Messages at QoS 0 have no answers. For robots that discover their
    /// broker.
    static constexpr Duration silence{to_duration(std::chrono::milliseconds{500})};

    RobotCore(client::ClientCore& client, client::Output& scratch, const RobotSettings& settings,
              const romano_board& board, Controller& controller);
    RobotCore(const RobotCore&) = delete;
    RobotCore& operator=(const RobotCore&) = delete;

    /// Does all that is due; returns when it wants to be called again at the latest. Call it
    /// earlier when a datagram has come.
    Instant run();

    /// Says goodbye, at once and for good; run() repeats it until the broker confirms.
    void leave();
    /// The broker confirmed the goodbye, or there is none to confirm it.
    [[nodiscard]] bool has_left() const { return is_leaving_ && (!broker_ || node_.has_left()); }

    /// The oldest movement command; false when there is none.
    bool next_command(romano_command& command) { return romano_mailbox_get(&mailbox_, &command); }

    /// As of node::Node; false when it cannot be taken now.
    template <typename M>
    bool publish(std::string_view topic, const M& message, mqttsn::Qos qos) {
        return node_.publish(now_, topic, message, qos, *this);
    }
    bool subscribe(std::string_view topic);
    bool request_connected_nodes();

    [[nodiscard]] Instant now() const;
    [[nodiscard]] const node::Node& node() const { return node_; }
    [[nodiscard]] const std::optional<Endpoint>& broker() const { return broker_; }
    [[nodiscard]] const romano_mailbox& mailbox() const { return mailbox_; }

protected:
    ~RobotCore() = default;

private:
    void receive_all();
    [[gnu::noinline]] void choose_broker();  // its stack is not run()'s
    void heed_silence();
    void forgive_silence();
    [[nodiscard]] Instant silence_ends_at() const;
    [[nodiscard]] std::optional<int> link_dbm(const romano_address& peer) const;

    void send(Bytes datagram) override;
    void on_established() override { controller_.on_established(); }
    void on_publish_request(std::string_view topic, Bytes kind_of_data) override {
        controller_.on_publish_request(topic, kind_of_data);
    }
    void on_message(std::string_view topic, Bytes message) override {
        controller_.on_message(topic, message);
    }

    const romano_board& board_;
    Controller& controller_;
    romano_mailbox mailbox_{};
    node::Node node_;
    const bool discovers_;
    BrokerChoice choice_;
    std::optional<Endpoint> broker_;
    std::uint32_t losses_seen_ = 0;
    Instant unanswered_since_ = never;  // the oldest datagram to the broker since it was heard
    bool is_probing_ = false;
    bool is_broker_silent_ = false;
    bool is_leaving_ = false;
    Instant now_{};
};

template <typename Limits>
struct RobotStorage {
    explicit RobotStorage(const RobotSettings& settings) : client(settings.timing, settings.seed) {}
    client::Client<Limits> client;
    client::OutputFor<Limits> scratch;
};

/// With its storage; it stays where it was made. `board` and `controller` outlive it.
template <typename Limits = client::DeviceLimits>
class Robot final : private RobotStorage<Limits>, public RobotCore {
public:
    Robot(const RobotSettings& settings, const romano_board& board, Controller& controller)
        : RobotStorage<Limits>(settings),
          RobotCore(this->client, this->scratch, settings, board, controller) {}
};

}  // namespace romano::firmware
