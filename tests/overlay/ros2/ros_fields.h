// The ROS 2 messages that are bridged, field by field after their .msg files, for a peer that
// shares no code and no IDL with the bridge. `visit` calls its visitor with each field in turn.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace romano::ros2::peer {

// NOLINTBEGIN: names as in the .msg files
struct Time {
    std::int32_t sec = 0;
    std::uint32_t nanosec = 0;
    template <class V>
    void visit(V&& v) {
        v(sec), v(nanosec);
    }
};

struct Header {
    Time stamp;
    std::string frame_id;
    template <class V>
    void visit(V&& v) {
        v(stamp), v(frame_id);
    }
};

struct Vector3 {
    double x = 0, y = 0, z = 0;
    template <class V>
    void visit(V&& v) {
        v(x), v(y), v(z);
    }
};

struct Quaternion {
    double x = 0, y = 0, z = 0, w = 0;
    template <class V>
    void visit(V&& v) {
        v(x), v(y), v(z), v(w);
    }
};

struct Twist {
    Vector3 linear, angular;
    template <class V>
    void visit(V&& v) {
        v(linear), v(angular);
    }
};

struct Pose {
    Vector3 position;
    Quaternion orientation;
    template <class V>
    void visit(V&& v) {
        v(position), v(orientation);
    }
};

template <class What>
struct WithCovariance {
    What what;
    std::array<double, 36> covariance{};
    template <class V>
    void visit(V&& v) {
        v(what);
        for (double& value : covariance) v(value);
    }
};

struct Odometry {
    Header header;
    std::string child_frame_id;
    WithCovariance<Pose> pose;
    WithCovariance<Twist> twist;
    template <class V>
    void visit(V&& v) {
        v(header), v(child_frame_id), v(pose), v(twist);
    }
};

struct BatteryState {
    Header header;
    float voltage = 0, temperature = 0, current = 0, charge = 0, capacity = 0, design_capacity = 0,
          percentage = 0;
    std::uint8_t power_supply_status = 0, power_supply_health = 0, power_supply_technology = 0;
    bool present = false;
    std::vector<float> cell_voltage, cell_temperature;
    std::string location, serial_number;
    template <class V>
    void visit(V&& v) {
        v(header), v(voltage), v(temperature), v(current), v(charge), v(capacity);
        v(design_capacity), v(percentage), v(power_supply_status), v(power_supply_health);
        v(power_supply_technology), v(present), v(cell_voltage), v(cell_temperature);
        v(location), v(serial_number);
    }
};

struct HumbleRange {
    Header header;
    std::uint8_t radiation_type = 0;
    float field_of_view = 0, min_range = 0, max_range = 0, range = 0;
    template <class V>
    void visit(V&& v) {
        v(header), v(radiation_type), v(field_of_view), v(min_range), v(max_range), v(range);
    }
};

struct Range : HumbleRange {
    float variance = 0;
    template <class V>
    void visit(V&& v) {
        HumbleRange::visit(v);
        v(variance);
    }
};

struct String {
    std::string data;
    template <class V>
    void visit(V&& v) {
        v(data);
    }
};

struct MultiArrayDimension {
    std::string label;
    std::uint32_t size = 0, stride = 0;
    template <class V>
    void visit(V&& v) {
        v(label), v(size), v(stride);
    }
};

struct UInt8MultiArray {
    std::vector<MultiArrayDimension> dim;
    std::uint32_t data_offset = 0;
    std::vector<std::uint8_t> data;
    template <class V>
    void visit(V&& v) {
        v(dim), v(data_offset), v(data);
    }
};

template <std::size_t size>
struct Gid {
    std::array<std::uint8_t, size> data{};
    template <class V>
    void visit(V&& v) {
        for (std::uint8_t& octet : data) v(octet);
    }
};

template <std::size_t gid>
struct NodeEntitiesInfo {
    std::string node_namespace, node_name;
    std::vector<Gid<gid>> reader_gid_seq, writer_gid_seq;
    template <class V>
    void visit(V&& v) {
        v(node_namespace), v(node_name), v(reader_gid_seq), v(writer_gid_seq);
    }
};

template <std::size_t gid_size>
struct ParticipantEntitiesInfo {
    Gid<gid_size> gid;
    std::vector<NodeEntitiesInfo<gid_size>> node_entities_info_seq;
    template <class V>
    void visit(V&& v) {
        v(gid), v(node_entities_info_seq);
    }
};
// NOLINTEND

}  // namespace romano::ros2::peer
