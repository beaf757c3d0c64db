// What a ROS 2 node puts on DDS by rmw_cyclonedds: std_msgs/UInt8MultiArray with ROS 2's names and
// QoS, and ros_discovery_info. Cyclone DDS as it is without configuration.

#include <dds/dds.h>

#include <array>
#include <map>
#include <string_view>
#include <utility>

#include "bench/ros/node/data_path.h"
#include "bench/ros/node/ros_names.h"
#include "broker/net/clock.h"
#include "overlay/dds/entity.h"
#include "overlay/dds/qos.h"
#include "overlay/ros2/dds/node_graph.h"
#include "overlay/ros2/dds/ros_types.h"

namespace romano::bench::ros {
namespace {

using Message = std_msgs_msg_dds__UInt8MultiArray_;

dds::Entity make_participant() {
    const dds::Qos qos{dds_create_qos()};
    constexpr std::string_view user_data = enclave;
    dds_qset_userdata(qos.get(), user_data.data(), user_data.size());
    return {dds_create_participant(0, qos.get(), nullptr), "participant"};
}

class CyclonePath : public DataPath {
public:
    CyclonePath(const NodePlan& plan, OnMessage on_message)
        : on_message_(std::move(on_message)),
          participant_(make_participant()),
          graph_(participant_, ros2::Release::iron),
          // A node hears what the others tell of themselves, and keeps it.
          heard_graph_topic_(
              dds_create_topic(participant_.handle(),
                               &rmw_dds_common_msg_dds__ParticipantEntitiesInfo__desc,
                               "ros_discovery_info", nullptr, nullptr),
              "topic ros_discovery_info"),
          heard_graph_(dds_create_reader(participant_.handle(), heard_graph_topic_.handle(),
                                         dds::reliable_for_late_readers(1, 1).get(), nullptr),
                       "reader of ros_discovery_info"),
          waits_(dds_create_waitset(participant_.handle()), "waitset") {
        // A waitset with nothing in it does not wait.
        dds_waitset_attach(waits_.handle(), dds_create_guardcondition(participant_.handle()), 0);
        const dds::Qos qos =
            plan.reliable ? dds::reliable(reliable_depth) : dds::best_effort(best_effort_depth);
        const dds_data_representation_id_t plain = DDS_DATA_REPRESENTATION_XCDR1;
        dds_qset_data_representation(qos.get(), 1, &plain);
        dds_qset_writer_data_lifecycle(qos.get(), false);
        for (const std::string& topic : plan.publishes) {
            writers_.emplace_back(
                dds_create_writer(participant_.handle(), topic_of(topic), qos.get(), nullptr),
                "writer of " + topic);
            graph_.add(plan.name, writers_.back(), true);
        }
        for (const std::string& topic : plan.subscribes) {
            readers_.emplace_back(
                dds_create_reader(participant_.handle(), topic_of(topic), qos.get(), nullptr),
                "reader of " + topic);
            graph_.add(plan.name, readers_.back(), false);
            const dds_entity_t condition =
                dds_create_readcondition(readers_.back().handle(), DDS_ANY_STATE);
            dds_waitset_attach(waits_.handle(), condition, readers_.back().handle());
        }
        graph_.tell();
    }
    void publish(std::size_t topic, Bytes payload) override {
        Message message{};
        message.data._length = message.data._maximum = static_cast<std::uint32_t>(payload.size());
        message.data._buffer = const_cast<std::uint8_t*>(payload.data());  // DDS only reads it
        (void)dds_write(writers_[topic].handle(), &message);
    }
    void turn(Instant until) override {
        std::array<dds_attach_t, 32> ready{};
        const auto left = std::max(Duration{0}, until - net::now());
        const dds_return_t count =
            dds_waitset_wait(waits_.handle(), ready.data(), ready.size(), left.count());
        for (dds_return_t i = 0; i < count; ++i) {
            take(static_cast<dds_entity_t>(ready[static_cast<std::size_t>(i)]));
        }
    }

private:
    dds_entity_t topic_of(const std::string& topic) {
        dds::Entity& made = topics_[topic];
        if (made.handle() == 0) {
            made = dds::Entity(
                dds_create_topic(participant_.handle(), &std_msgs_msg_dds__UInt8MultiArray__desc,
                                 dds_topic_of(topic).c_str(), nullptr, nullptr),
                "topic " + topic);
        }
        return made.handle();
    }
    void take(dds_entity_t reader) {
        std::array<void*, 16> samples{};  // DDS lends them
        std::array<dds_sample_info_t, 16> infos{};
        const dds_return_t taken =
            dds_take(reader, samples.data(), infos.data(), samples.size(), samples.size());
        for (std::size_t i = 0; taken > 0 && i < static_cast<std::size_t>(taken); ++i) {
            if (!infos[i].valid_data) continue;
            const auto& data = static_cast<const Message*>(samples[i])->data;
            on_message_({data._buffer, data._length});
        }
        if (taken > 0) dds_return_loan(reader, samples.data(), taken);
    }

    OnMessage on_message_;
    dds::Entity participant_;
    ros2::NodeGraph graph_;
    dds::Entity heard_graph_topic_;
    dds::Entity heard_graph_;
    dds::Entity waits_;
    std::map<std::string, dds::Entity> topics_;
    std::vector<dds::Entity> writers_;
    std::vector<dds::Entity> readers_;
};

}  // namespace

std::unique_ptr<DataPath> make_data_path(const NodePlan& plan, DataPath::OnMessage on_message) {
    return std::make_unique<CyclonePath>(plan, std::move(on_message));
}

}  // namespace romano::bench::ros
