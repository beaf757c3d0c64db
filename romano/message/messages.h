// ROMANO messages: the Data field of one MQTT-SN PUBLISH. Paper, tables "ROMANO Message Formats"
// and "Movement Control Types".
//
// Texts and octets are views: after decoding they point into the received data and live as long as
// it does.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <variant>

#include "romano/base/bytes.h"
#include "romano/message/romano_id.h"

namespace romano::message {

/// Octet 0. Values from 0x13 on are the application's own; 0x0D to 0x10 are reserved.
enum class DataType : std::uint8_t {
    normal_data = 0x00,
    mqtt_subscribe = 0x01,
    mqtt_publish_request = 0x02,
    connected_nodes = 0x03,
    request_connected_nodes = 0x04,
    rssi_report = 0x05,
    sensor_data = 0x06,
    movement_control = 0x07,
    remote_control = 0x08,
    mqtt_unsubscribe = 0x09,
    heartbeat = 0x0A,
    connection_request = 0x0B,
    connection_ack = 0x0C,
    udp_send_req = 0x11,
    udp_send_go = 0x12,
    first_of_application = 0x13,
};

/// Whoever takes such a message moves.
constexpr bool is_movement(DataType type) {
    return type == DataType::movement_control || type == DataType::remote_control;
}

inline constexpr std::size_t max_message = 255;  // octets, header included
inline constexpr std::size_t max_ids_in_message = 31;

/// Octets 2-3 of movement control. 0x0006 to 0x7FFF are reserved, from 0x8000 on the application's
/// own.
enum class MovementType : std::uint16_t {
    front = 0x0000,  // distance, u32, mm
    back = 0x0001,
    left = 0x0002,
    right = 0x0003,
    rotate_left = 0x0004,  // angle, u32, millidegrees
    rotate_right = 0x0005,
    first_of_application = 0x8000,
};

/// Octets 2-3 of sensor data. 0x0006 to 0x7FFF are reserved, from 0x8000 on the application's own.
enum class SensorType : std::uint16_t {
    gyroscope = 0x0000,         // 3 x i32, millidegrees a second
    proximity = 0x0001,         // u32, mm
    location = 0x0002,          // i32 x mm, i32 y mm, i32 heading millidegrees
    speed = 0x0003,             // i32 mm a second, i32 millidegrees a second
    battery = 0x0004,           // u16, mV
    line_reflectance = 0x0005,  // 5 x u16
    first_of_application = 0x8000,
};

struct NormalData {
    Bytes data;
};
/// Tells the receivers to subscribe to the topic, or to unsubscribe from it.
struct MqttSubscribe {
    std::string_view topic;
};
struct MqttUnsubscribe {
    std::string_view topic;
};
/// Tells the receivers to publish that kind of data to that topic.
struct MqttPublishRequest {
    std::string_view topic;
    Bytes kind_of_data;
};
/// Ids of connected nodes, 8 octets each; a message with fewer than 31 ends the list.
struct ConnectedNodes {
    Bytes ids;  // a multiple of 8 octets, each id valid
    [[nodiscard]] std::size_t count() const { return ids.size() / RomanoId::size; }
    [[nodiscard]] RomanoId at(std::size_t index) const;
    [[nodiscard]] bool ends_the_list() const { return count() < max_ids_in_message; }
};
struct RequestConnectedNodes {
    RomanoId asker;
};
struct RssiReport {
    RomanoId heard;
    std::int8_t rssi_dbm;
};
struct SensorData {
    SensorType type;
    Bytes value;
};
struct MovementControl {
    MovementType type;
    Bytes arguments;
};
struct RemoteControl {
    Bytes data;
};
struct Heartbeat {
    RomanoId sender;
};
struct ConnectionRequest {
    RomanoId sender;
};
struct ConnectionAck {};
struct UdpSendReq {};
struct UdpSendGo {};
/// Types 0x13 to 0xFF.
struct ApplicationData {
    std::uint8_t type;
    Bytes data;
};

using Message = std::variant<NormalData, MqttSubscribe, MqttPublishRequest, ConnectedNodes,
                             RequestConnectedNodes, RssiReport, SensorData, MovementControl,
                             RemoteControl, MqttUnsubscribe, Heartbeat, ConnectionRequest,
                             ConnectionAck, UdpSendReq, UdpSendGo, ApplicationData>;

}  // namespace romano::message
