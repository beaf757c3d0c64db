// Looks at a fleet with one broker's eyes, as a plain MQTT-SN client that hears everything, keeps
// the picture, and carries orders out. When its broker does not answer any more it asks again each
// second.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "experiments/fleet/fleet_picture.h"
#include "experiments/fleet/loop_stop.h"
#include "experiments/fleet/missed_entries.h"
#include "experiments/robots/socket_client.h"
#include "experiments/web/web_api.h"

namespace romano::experiments {

struct FleetWatchOptions {
    BrokerAddress broker;
    std::string client_id;
    std::shared_ptr<keys::ClientPackets> packets;  // null: plain
    client::Timing timing;
    client::KeepAlive keep_alive{60};
    std::vector<std::string> filters = {"#"};  // what it hears, beside what tells of the fleet
    Duration ask_every{0};                     // where each robot is, if it does not say; 0: never
};

class FleetWatch final : public Steering {
public:
    FleetWatch(boost::asio::io_context& io, FleetWatchOptions options, FleetPicture& picture);

    std::uint64_t carry_out(const Orders& orders) override;
    void leave();

    /// It was connected at least once.
    [[nodiscard]] bool has_begun() const { return has_begun_; }
    /// No answer after all repetitions, or a refusal.
    [[nodiscard]] bool has_failed() const { return failed_; }
    /// The broker answered, with a refusal.
    [[nodiscard]] std::optional<mqttsn::ReturnCode> denial() const { return denial_; }
    [[nodiscard]] bool was_refused() const { return client_ && client_->was_refused(); }

private:
    struct Echo {
        std::uint64_t number;
        Instant sent;
    };

    void connect();
    void subscribe_to_all();
    void subscribe_to_entries();
    void on_event(const client::Event& event);
    void on_received(const client::Received& received);
    void on_echo(Bytes data);
    void on_ended(client::OperationId operation, bool broker_has_it);
    void lose();
    void publish(std::string_view topic, Bytes data, mqttsn::Qos qos);
    void tell(const LoopStop::ToRobot& message);
    void send_next();
    void end_command(std::uint64_t command, bool broker_has_it);
    void tick();
    void look_for_missed_entries(Instant now);
    void send_echo(Instant now);
    void ask_for_places(Instant now);

    boost::asio::io_context& io_;
    FleetWatchOptions options_;
    FleetPicture& picture_;
    LoopStop loops_;
    MissedEntries missed_;
    std::optional<client::OperationId> entries_;  // the subscription to them, not taken yet
    std::string echo_topic_;
    boost::asio::steady_timer timer_;
    std::unique_ptr<WatcherClient> client_;
    std::unique_ptr<WatcherClient> old_client_;  // a timer of its own may be about to call it
    unsigned life_ = 0;                          // of the client
    struct Outgoing {
        Order order;
        std::uint64_t command;
    };
    std::deque<Outgoing> outgoing_;                      // in the order of their commands
    std::deque<message::RomanoId> loops_to_end_;         // when all of those are out
    std::map<client::OperationId, std::uint64_t> open_;  // exchanges, with their commands, or none
    std::deque<Echo> echoes_;                            // the oldest first
    std::uint64_t last_echo_ = 0;
    Instant echo_due_{};
    std::optional<Instant> connect_due_;
    std::map<message::RomanoId, Instant> asked_;
    bool leaving_ = false;
    bool has_begun_ = false;
    bool failed_ = false;
    std::optional<mqttsn::ReturnCode> denial_;
};

}  // namespace romano::experiments
