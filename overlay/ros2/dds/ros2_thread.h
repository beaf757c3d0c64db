// The thread that the bridge to ROS 2 runs on.
#pragma once

#include <boost/asio/io_context.hpp>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <variant>
#include <vector>

#include "broker/uplink/uplink_core.h"
#include "overlay/ros2/bridge_core.h"
#include "overlay/ros2/dds/ros2_link.h"
#include "overlay/ros2/dds/ros_side.h"

namespace romano::ros2 {

class Ros2Thread : public std::enable_shared_from_this<Ros2Thread> {
public:
    static constexpr std::size_t most_waiting = 4096;  // messages, each way

    /// Throws DdsError.
    Ros2Thread(boost::asio::io_context& io, const RosSettings& settings, std::vector<Rule> rules,
               uplink::LinkEvents events);

    // --- the broker's thread
    void start();
    void open();
    void close();
    void publish(const uplink::PublishUp& message);
    /// No event comes after this. Waits for the thread to end.
    void stop();
    [[nodiscard]] Ros2Facts facts() const;

private:
    struct Outgoing {
        FromRomano message;
        broker::LogPosition position;
        bool wants_answer = false;
    };
    struct Open {};
    struct Close {};
    using Command = std::variant<Open, Close, Outgoing>;
    /// For the broker's thread, from one life of the link.
    struct Report {
        std::uint64_t life = 0;
        bool is_up = false;
        std::vector<broker::LogPosition> answered;
        std::vector<uplink::FromRemote> messages;
    };

    void command(Command what);
    void run();
    /// Waits for something to do; false when it is time to end.
    bool wait(std::deque<Command>& commands);
    void carry_out(const Command& command);
    void look_at_writers();
    /// Some of those that were there when the bridge was opened; true when there are more.
    bool meet_known();
    void meet(const RosWriter& writer);
    void carry_out_actions();
    void tell_nodes();
    void send_report();
    void on_report(Report& report);

    boost::asio::io_context& io_;
    uplink::LinkEvents events_;  // the broker's thread only
    std::thread runs_;

    mutable std::mutex mutex_;
    std::condition_variable changed_;
    bool stopping_ = false;
    bool ready_ = false;  // DDS has something
    std::deque<Command> commands_;
    std::size_t waiting_out_ = 0;  // messages among them
    std::size_t waiting_in_ = 0;   // messages in posted reports
    std::uint64_t life_ = 0;       // of the link: which open() the broker's thread called last
    Ros2Facts facts_;

    // --- its own thread only
    BridgeCore core_;
    RosSide side_;  // its listeners use mutex_ and changed_
    bool is_open_ = false;
    std::uint64_t open_life_ = 0;
    std::deque<RosWriter> known_;  // from before it was opened, not met yet
    Instant now_{};
    Instant tell_nodes_at_ = Instant::min();
    std::vector<BridgeAction> actions_;
    std::string identity_;  // of the sample that actions_ come from
    Report report_;
    std::set<std::string> warned_;  // topics that people were told of
};

}  // namespace romano::ros2
