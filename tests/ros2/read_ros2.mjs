// Reads what the bridge says with an RTPS stack and a message decoder that others wrote (@foxglove/ros2):
// `node read_ros2.mjs DOMAIN TOPIC=TYPE...`. Prints "read TOPIC" and JSON, a line for each message, until it is ended. It asks for
// transient-local publishers, at 127.0.0.1.

import {createRequire} from 'node:module';

const require = createRequire(process.env.ROS2_TEST_MODULES + '/');
const {RosNode} = require('@foxglove/ros2');
const {UdpSocketNode} = require('@foxglove/ros2/nodejs');
const {parse} = require('@foxglove/rosmsg');

// As in the .msg files.
const header = 'std_msgs/Header header';
const ofHeader = `
================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
`;
const ofTwist = `
================
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
`;
const types = {
    'std_msgs/msg/String': 'string data',
    'std_msgs/msg/UInt8MultiArray': `std_msgs/MultiArrayLayout layout
uint8[] data
================
MSG: std_msgs/MultiArrayLayout
std_msgs/MultiArrayDimension[] dim
uint32 data_offset
================
MSG: std_msgs/MultiArrayDimension
string label
uint32 size
uint32 stride`,
    'geometry_msgs/msg/Twist': `geometry_msgs/Vector3 linear
geometry_msgs/Vector3 angular${ofTwist}`,
    'nav_msgs/msg/Odometry': `${header}
string child_frame_id
geometry_msgs/PoseWithCovariance pose
geometry_msgs/TwistWithCovariance twist${ofHeader}${ofTwist}================
MSG: geometry_msgs/PoseWithCovariance
geometry_msgs/Pose pose
float64[36] covariance
================
MSG: geometry_msgs/Pose
geometry_msgs/Vector3 position
geometry_msgs/Quaternion orientation
================
MSG: geometry_msgs/Quaternion
float64 x
float64 y
float64 z
float64 w
================
MSG: geometry_msgs/TwistWithCovariance
geometry_msgs/Twist twist
float64[36] covariance
================
MSG: geometry_msgs/Twist
geometry_msgs/Vector3 linear
geometry_msgs/Vector3 angular`,
    'sensor_msgs/msg/BatteryState': `${header}
float32 voltage
float32 temperature
float32 current
float32 charge
float32 capacity
float32 design_capacity
float32 percentage
uint8 power_supply_status
uint8 power_supply_health
uint8 power_supply_technology
bool present
float32[] cell_voltage
float32[] cell_temperature
string location
string serial_number${ofHeader}`,
    'sensor_msgs/msg/Range': `${header}
uint8 radiation_type
float32 field_of_view
float32 min_range
float32 max_range
float32 range
float32 variance${ofHeader}`,
};

const [domain, ...wanted] = process.argv.slice(2);
const node = new RosNode({
    name: 'reader',
    addresses: ['127.0.0.1'],
    domainId: Number(domain),
    udpSocketCreate: UdpSocketNode.Create,
});
await node.start();
for (const word of wanted) {
    const [topic, dataType] = word.split('=');
    const subscription = node.subscribe({topic, dataType, msgDefinition: parse(types[dataType], {ros2: true})});
    subscription.on('message', (_time, message) => {
        const asArray = (_key, value) => (ArrayBuffer.isView(value) ? [...value] : value);
        console.log(`read ${topic} ${JSON.stringify(message, asArray)}`);
    });
}
