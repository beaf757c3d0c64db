#include "overlay/ros2/ros_types.h"

#include <algorithm>
#include <array>

namespace romano::ros2 {
namespace {

struct TypeNames {
    std::string_view name;
    std::string_view hash;  // REP 2016: SHA-256 of the type's description, from Iron on
};

constexpr std::array<TypeNames, ros_types> types{{
    {"geometry_msgs/msg/Twist", "9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a"},
    {"nav_msgs/msg/Odometry", "3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0"},
    {"sensor_msgs/msg/BatteryState",
     "4bee5dfce981c98faa6828b868307a0a73f992ed0789f374ee96c8f840e69741"},
    {"sensor_msgs/msg/Range", "b42b62562e93cbfe9d42b82fe5994dfa3d63d7d5c90a317981703f7388adff3a"},
    {"std_msgs/msg/String", "df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"},
    {"std_msgs/msg/UInt8MultiArray",
     "5687e861b8d307a5e48b7515467ae7a5fc2daf805bd0ce6d8e9e604bade9f385"},
}};

constexpr std::string_view of_a_bridge = "romano=bridge;";
constexpr std::string_view topic_prefix = "rt";

const TypeNames& names(RosType type) {
    return types[static_cast<std::size_t>(type)];
}

bool is_letter(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}

bool is_digit(char c) {
    return c >= '0' && c <= '9';
}

}  // namespace

std::string_view name_of(RosType type) {
    return names(type).name;
}

std::optional<RosType> type_named(std::string_view name) {
    const auto found = std::ranges::find(types, name, &TypeNames::name);
    if (found == types.end()) return std::nullopt;
    return static_cast<RosType>(found - types.begin());
}

std::string names_of_types() {
    std::string out;
    for (std::size_t i = 0; i < types.size(); ++i) {
        if (i > 0) out += i + 1 == types.size() ? " or " : ", ";
        out += types[i].name;
    }
    return out;
}

std::string dds_type_name(RosType type) {
    std::string out;
    for (const char c : name_of(type)) {
        out += c == '/' ? "::" : std::string{c};
    }
    out.insert(out.rfind("::") + 2, "dds_::");
    return out + '_';
}

std::string ros_type_name(std::string_view dds_type) {
    constexpr std::string_view middle = "::dds_::";
    const auto at = dds_type.find(middle);
    if (at == std::string_view::npos || !dds_type.ends_with('_')) return {};
    std::string out{dds_type.substr(0, at)};
    for (auto colons = out.find("::"); colons != std::string::npos; colons = out.find("::")) {
        out.replace(colons, 2, "/");
    }
    dds_type.remove_prefix(at + middle.size());
    return out + '/' + std::string{dds_type.substr(0, dds_type.size() - 1)};
}

std::string dds_topic_name(std::string_view topic) {
    return std::string{topic_prefix} + std::string{topic};
}

std::string ros_topic_name(std::string_view dds_topic) {
    if (!dds_topic.starts_with(topic_prefix)) return {};
    dds_topic.remove_prefix(topic_prefix.size());
    return is_ros_topic(dds_topic) ? std::string{dds_topic} : std::string{};
}

bool is_ros_name(std::string_view name) {
    if (name.empty() || is_digit(name.front()) || name.find("__") != std::string_view::npos) {
        return false;
    }
    return std::ranges::all_of(name, [](char c) { return is_letter(c) || is_digit(c); });
}

bool is_ros_topic(std::string_view name) {
    if (!name.starts_with('/')) return false;
    while (!name.empty()) {
        name.remove_prefix(1);
        const auto end = std::min(name.find('/'), name.size());
        if (!is_ros_name(name.substr(0, end))) return false;
        name.remove_prefix(end);
    }
    return true;
}

std::string endpoint_user_data(RosType type, Release release) {
    std::string out;
    if (release != Release::humble) {
        out = "typehash=RIHS01_" + std::string{names(type).hash} + ';';
    }
    return out + std::string{of_a_bridge};
}

bool is_of_a_bridge(std::string_view user_data) {
    return user_data.find(of_a_bridge) != std::string_view::npos;
}

}  // namespace romano::ros2
