// What a ROS 2 node puts on DDS by rmw_fastrtps: std_msgs/UInt8MultiArray with ROS 2's names and
// QoS, and ros_discovery_info. Fast DDS over UDP: its shared memory is for nodes of one machine.

#include <fastcdr/Cdr.h>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>

#include <algorithm>
#include <fastdds/dds/core/condition/WaitSet.hpp>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <map>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "bench/ros/node/as_octets.h"
#include "bench/ros/node/data_path.h"
#include "bench/ros/node/ros_names.h"
#include "broker/net/clock.h"

namespace romano::bench::ros {
namespace {

using namespace eprosima::fastdds::dds;
using eprosima::fastcdr::Cdr;
using eprosima::fastcdr::FastBuffer;
using Octets = AsOctets::Octets;

constexpr std::uint32_t octets_at_first = 1024;
constexpr const char* graph_topic = "ros_discovery_info";
constexpr const char* graph_type = "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_";

/// CDR, little-endian, with its encapsulation header.
Octets encoded(std::size_t at_most, const std::function<void(Cdr&)>& write) {
    Octets room(at_most);
    FastBuffer buffer(reinterpret_cast<char*>(room.data()), room.size());
    Cdr cdr(buffer, Cdr::LITTLE_ENDIANNESS, Cdr::DDS_CDR);
    cdr.serialize_encapsulation();
    write(cdr);
    room.resize(cdr.getSerializedDataLength());
    return room;
}

constexpr std::size_t before_data = 16;  // encapsulation, no dimensions, data_offset, length

Octets message_of(Bytes payload) {
    return encoded(before_data + payload.size(), [payload](Cdr& cdr) {
        cdr << std::uint32_t{0} << std::uint32_t{0} << static_cast<std::uint32_t>(payload.size());
        cdr.serializeArray(payload.data(), payload.size());
    });
}

Octets gid_of(const eprosima::fastrtps::rtps::GUID_t& guid) {
    Octets gid(guid.guidPrefix.value, guid.guidPrefix.value + 12);
    gid.insert(gid.end(), guid.entityId.value, guid.entityId.value + 4);
    return gid;
}

template <class Qos>
Qos ros_qos(Qos qos, ReliabilityQosPolicyKind reliability, DurabilityQosPolicyKind durability,
            int depth) {
    qos.reliability().kind = reliability;
    qos.durability().kind = durability;
    qos.history().kind = KEEP_LAST_HISTORY_QOS;
    qos.history().depth = depth;
    qos.data_sharing().off();
    qos.endpoint().history_memory_policy =
        eprosima::fastrtps::rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    return qos;
}

class FastDdsPath : public DataPath {
public:
    FastDdsPath(const NodePlan& plan, OnMessage on_message) : on_message_(std::move(on_message)) {
        DomainParticipantQos qos;
        const std::string_view user_data = enclave;
        qos.user_data().setValue({user_data.begin(), user_data.end()});
        qos.transport().use_builtin_transports = false;
        qos.transport().user_transports.push_back(
            std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>());
        participant_ = DomainParticipantFactory::get_instance()->create_participant(0, qos);
        if (participant_ == nullptr) throw std::runtime_error("Fast DDS makes no participant");
        publisher_ = participant_->create_publisher(PUBLISHER_QOS_DEFAULT);
        subscriber_ = participant_->create_subscriber(SUBSCRIBER_QOS_DEFAULT);
        const auto reliability =
            plan.reliable ? RELIABLE_RELIABILITY_QOS : BEST_EFFORT_RELIABILITY_QOS;
        const int depth = plan.reliable ? reliable_depth : best_effort_depth;
        for (const std::string& topic : plan.publishes) {
            writers_.push_back(make_writer(dds_topic_of(topic), dds_type, reliability,
                                           VOLATILE_DURABILITY_QOS, depth));
        }
        for (const std::string& topic : plan.subscribes) {
            readers_.push_back(make_reader(dds_topic_of(topic), dds_type, reliability,
                                           VOLATILE_DURABILITY_QOS, depth));
            StatusCondition& condition = readers_.back()->get_statuscondition();
            condition.set_enabled_statuses(StatusMask::data_available());
            waits_.attach_condition(condition);
        }
        // A node hears what the others tell of themselves, and keeps it.
        (void)make_reader(graph_topic, graph_type, RELIABLE_RELIABILITY_QOS,
                          TRANSIENT_LOCAL_DURABILITY_QOS, 1);
        Octets graph = graph_of(plan);
        make_writer(graph_topic, graph_type, RELIABLE_RELIABILITY_QOS,
                    TRANSIENT_LOCAL_DURABILITY_QOS, 1)
            ->write(&graph);
    }
    ~FastDdsPath() override {
        participant_->delete_contained_entities();
        DomainParticipantFactory::get_instance()->delete_participant(participant_);
    }
    void publish(std::size_t topic, Bytes payload) override {
        Octets message = message_of(payload);
        writers_[topic]->write(&message);
    }
    void turn(Instant until) override {
        ConditionSeq ready;
        const auto left = std::max(Duration{0}, until - net::now());
        waits_.wait(ready, eprosima::fastrtps::Duration_t(
                               std::chrono::duration<long double>(left).count()));
        SampleInfo info;
        for (DataReader* reader : readers_) {
            while (reader->take_next_sample(&received_, &info) == ReturnCode_t::RETCODE_OK) {
                if (!info.valid_data || received_.size() < before_data) continue;
                on_message_(Bytes{received_}.subspan(before_data));
            }
        }
    }

private:
    Topic* topic_of(const std::string& name, const char* type) {
        if (participant_->find_type(type).empty()) {
            participant_->register_type(TypeSupport(new AsOctets(type, octets_at_first)));
        }
        Topic*& made = topics_[name];
        if (made == nullptr) made = participant_->create_topic(name, type, TOPIC_QOS_DEFAULT);
        return made;
    }
    DataWriter* make_writer(const std::string& topic, const char* type,
                            ReliabilityQosPolicyKind reliability,
                            DurabilityQosPolicyKind durability, int depth) {
        DataWriter* made = publisher_->create_datawriter(
            topic_of(topic, type), ros_qos(DATAWRITER_QOS_DEFAULT, reliability, durability, depth));
        if (made == nullptr) throw std::runtime_error("Fast DDS makes no writer of " + topic);
        return made;
    }
    DataReader* make_reader(const std::string& topic, const char* type,
                            ReliabilityQosPolicyKind reliability,
                            DurabilityQosPolicyKind durability, int depth) {
        DataReader* made = subscriber_->create_datareader(
            topic_of(topic, type), ros_qos(DATAREADER_QOS_DEFAULT, reliability, durability, depth));
        if (made == nullptr) throw std::runtime_error("Fast DDS makes no reader of " + topic);
        return made;
    }
    /// This participant's one node, and its endpoints (rmw_dds_common, Iron and later).
    Octets graph_of(const NodePlan& plan) const {
        return encoded(4096, [&](Cdr& cdr) {
            const auto put_gid = [&cdr](const auto& guid) {
                const Octets gid = gid_of(guid);
                cdr.serializeArray(gid.data(), gid.size());
            };
            put_gid(participant_->guid());
            cdr << std::uint32_t{1} << std::string("/") << plan.name
                << static_cast<std::uint32_t>(readers_.size());
            for (const DataReader* reader : readers_) put_gid(reader->guid());
            cdr << static_cast<std::uint32_t>(writers_.size());
            for (const DataWriter* writer : writers_) put_gid(writer->guid());
        });
    }

    OnMessage on_message_;
    DomainParticipant* participant_ = nullptr;
    Publisher* publisher_ = nullptr;
    Subscriber* subscriber_ = nullptr;
    std::map<std::string, Topic*> topics_;
    std::vector<DataWriter*> writers_;
    std::vector<DataReader*> readers_;
    WaitSet waits_;
    Octets received_;
};

}  // namespace

std::unique_ptr<DataPath> make_data_path(const NodePlan& plan, DataPath::OnMessage on_message) {
    return std::make_unique<FastDdsPath>(plan, std::move(on_message));
}

}  // namespace romano::bench::ros
