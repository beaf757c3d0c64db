#include "overlay/ros2/dds/ros_codec.h"

#include "overlay/ros2/dds/humble_types.h"
#include "overlay/ros2/dds/ros_types.h"

namespace romano::ros2 {
namespace {

using CTime = builtin_interfaces_msg_dds__Time_;
using CTwist = geometry_msgs_msg_dds__Twist_;
using COdometry = nav_msgs_msg_dds__Odometry_;
using CBatteryState = sensor_msgs_msg_dds__BatteryState_;
using CRange = sensor_msgs_msg_dds__Range_;
using CHumbleRange = humble_dds__Range_;
using CString = std_msgs_msg_dds__String_;
using COctets = std_msgs_msg_dds__UInt8MultiArray_;

// DDS only reads what it is given to write.
char* lent(const std::string& text) {
    return const_cast<char*>(text.c_str());
}

std::string copy_of(const char* text) {
    return text == nullptr ? std::string{} : std::string{text};
}

template <typename CHeader>
void put(CHeader& out, const Header& header) {
    out.stamp.sec = header.sec;
    out.stamp.nanosec = header.nanosec;
    out.frame_id = lent(header.frame_id);
}

template <typename CHeader>
Header header_in(const CHeader& header) {
    return {.sec = header.stamp.sec,
            .nanosec = header.stamp.nanosec,
            .frame_id = copy_of(header.frame_id)};
}

CTwist c_twist(const Twist& twist) {
    return {.linear = {twist.linear.x, twist.linear.y, twist.linear.z},
            .angular = {twist.angular.x, twist.angular.y, twist.angular.z}};
}

Twist twist_in(const CTwist& twist) {
    return {.linear = {twist.linear.x, twist.linear.y, twist.linear.z},
            .angular = {twist.angular.x, twist.angular.y, twist.angular.z}};
}

template <typename CRangeOfRelease>
CRangeOfRelease c_range(const Range& range) {
    CRangeOfRelease out{};
    put(out.header, range.header);
    out.radiation_type = range.radiation_type;
    out.field_of_view = range.field_of_view;
    out.min_range = range.min_range;
    out.max_range = range.max_range;
    out.range = range.range;
    return out;
}

template <typename CRangeOfRelease>
Range range_in(const CRangeOfRelease& range) {
    return {.header = header_in(range.header),
            .radiation_type = range.radiation_type,
            .field_of_view = range.field_of_view,
            .min_range = range.min_range,
            .max_range = range.max_range,
            .range = range.range};
}

struct Writer {
    dds_entity_t writer;
    Release release;

    dds_return_t operator()(const Twist& twist) const {
        const CTwist out = c_twist(twist);
        return dds_write(writer, &out);
    }
    dds_return_t operator()(const Odometry& odometry) const {
        COdometry out{};
        put(out.header, odometry.header);
        out.child_frame_id = lent(odometry.child_frame_id);
        const Vector3& at = odometry.position;
        const Quaternion& turned = odometry.orientation;
        out.pose.pose.position = {at.x, at.y, at.z};
        out.pose.pose.orientation = {turned.x, turned.y, turned.z, turned.w};
        out.twist.twist = c_twist(odometry.twist);
        return dds_write(writer, &out);
    }
    dds_return_t operator()(const BatteryState& state) const {
        CBatteryState out{};
        static const std::string unnamed;
        put(out.header, state.header);
        out.voltage = state.voltage;
        out.temperature = out.current = out.charge = not_measured;
        out.capacity = out.design_capacity = not_measured;
        out.percentage = state.percentage;
        out.present = true;
        out.location = out.serial_number = lent(unnamed);
        return dds_write(writer, &out);
    }
    dds_return_t operator()(const Range& range) const {
        if (release == Release::humble) {
            const auto out = c_range<CHumbleRange>(range);
            return dds_write(writer, &out);
        }
        const auto out = c_range<CRange>(range);
        return dds_write(writer, &out);
    }
    dds_return_t operator()(const String& text) const {
        const CString out{.data = lent(text.data)};
        return dds_write(writer, &out);
    }
    dds_return_t operator()(const UInt8MultiArray& octets) const {
        COctets out{};
        out.data._length = out.data._maximum = static_cast<std::uint32_t>(octets.data.size());
        out.data._buffer = const_cast<std::uint8_t*>(octets.data.data());
        return dds_write(writer, &out);
    }
};

dds_topic_descriptor_t range_of_humble() {
    dds_topic_descriptor_t out = humble_dds__Range__desc;
    out.m_typename = sensor_msgs_msg_dds__Range__desc.m_typename;
    return out;
}

}  // namespace

const dds_topic_descriptor_t& descriptor_of(RosType type, Release release) {
    static const dds_topic_descriptor_t humble_range = range_of_humble();
    switch (type) {
        case RosType::twist:
            return geometry_msgs_msg_dds__Twist__desc;
        case RosType::odometry:
            return nav_msgs_msg_dds__Odometry__desc;
        case RosType::battery_state:
            return sensor_msgs_msg_dds__BatteryState__desc;
        case RosType::range:
            return release == Release::humble ? humble_range : sensor_msgs_msg_dds__Range__desc;
        case RosType::string:
            return std_msgs_msg_dds__String__desc;
        case RosType::uint8_multi_array:
            break;
    }
    return std_msgs_msg_dds__UInt8MultiArray__desc;
}

dds_return_t write(dds_entity_t writer, const RosMessage& message, Release release) {
    return std::visit(Writer{writer, release}, message);
}

RosMessage message_in(const void* sample, RosType type, Release release) {
    switch (type) {
        case RosType::twist:
            return twist_in(*static_cast<const CTwist*>(sample));
        case RosType::odometry: {
            const auto& in = *static_cast<const COdometry*>(sample);
            const auto& pose = in.pose.pose;
            return Odometry{.header = header_in(in.header),
                            .child_frame_id = copy_of(in.child_frame_id),
                            .position = {pose.position.x, pose.position.y, pose.position.z},
                            .orientation = {pose.orientation.x, pose.orientation.y,
                                            pose.orientation.z, pose.orientation.w},
                            .twist = twist_in(in.twist.twist)};
        }
        case RosType::battery_state: {
            const auto& in = *static_cast<const CBatteryState*>(sample);
            return BatteryState{
                .header = header_in(in.header), .voltage = in.voltage, .percentage = in.percentage};
        }
        case RosType::range:
            if (release == Release::humble) {
                return range_in(*static_cast<const CHumbleRange*>(sample));
            }
            return range_in(*static_cast<const CRange*>(sample));
        case RosType::string:
            return String{copy_of(static_cast<const CString*>(sample)->data)};
        case RosType::uint8_multi_array:
            break;
    }
    const auto& data = static_cast<const COctets*>(sample)->data;
    UInt8MultiArray out;
    if (data._length != 0) out.data.assign(data._buffer, data._buffer + data._length);
    return out;
}

}  // namespace romano::ros2
