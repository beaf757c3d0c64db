// A ROS 1 node by roscpp: std_msgs/UInt8MultiArray. Reliable is TCP, with TCP_NODELAY; else UDP.

#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <std_msgs/UInt8MultiArray.h>

#include <memory>
#include <utility>

#include "bench/ros/node/data_path.h"
#include "broker/net/clock.h"

namespace romano::bench::ros {
namespace {

/// ROS 1's messages ask their allocator for `rebind`, which C++20 took from std::allocator.
template <typename T>
struct RosAllocator : std::allocator<T> {
    template <typename U>
    struct rebind {
        using other = RosAllocator<U>;
    };
    RosAllocator() = default;
    template <typename U>
    RosAllocator(const RosAllocator<U>&) {}
};
using Message = std_msgs::UInt8MultiArray_<RosAllocator<void>>;

constexpr std::uint32_t queue = 10;  // messages; what ROS 2 has by default

class Ros1Path : public DataPath {
public:
    Ros1Path(const NodePlan& plan, OnMessage on_message) : on_message_(std::move(on_message)) {
        ::ros::init(::ros::M_string{{"__master", "http://" + plan.infrastructure + ":11311"},
                                    {"__ip", plan.address}},
                    plan.name, ::ros::init_options::NoSigintHandler);
        node_ = std::make_unique<::ros::NodeHandle>();  // waits for the master
        for (const std::string& topic : plan.publishes) {
            publishers_.push_back(node_->advertise<Message>(topic, queue));
        }
        const auto transport = plan.reliable ? ::ros::TransportHints().tcpNoDelay()
                                             : ::ros::TransportHints().unreliable();
        for (const std::string& topic : plan.subscribes) {
            subscribers_.push_back(node_->subscribe<Message>(
                topic, queue,
                [this](const Message::ConstPtr& message) { on_message_(message->data); },
                ::ros::VoidConstPtr(), transport));
        }
    }
    ~Ros1Path() override {
        subscribers_.clear();
        publishers_.clear();
        ::ros::shutdown();
    }
    void publish(std::size_t topic, Bytes payload) override {
        message_.data.assign(payload.begin(), payload.end());
        publishers_[topic].publish(message_);
    }
    void turn(Instant until) override {
        const auto left = std::max(Duration{0}, until - net::now());
        ::ros::getGlobalCallbackQueue()->callAvailable(
            ::ros::WallDuration(std::chrono::duration<double>(left).count()));
    }

private:
    OnMessage on_message_;
    std::unique_ptr<::ros::NodeHandle> node_;
    std::vector<::ros::Publisher> publishers_;
    std::vector<::ros::Subscriber> subscribers_;
    Message message_;
};

}  // namespace

std::unique_ptr<DataPath> make_data_path(const NodePlan& plan, DataPath::OnMessage on_message) {
    return std::make_unique<Ros1Path>(plan, std::move(on_message));
}

}  // namespace romano::bench::ros
