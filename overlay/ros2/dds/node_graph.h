// What `ros2 node list` shows: each participant tells on the topic ros_discovery_info which nodes
// its endpoints belong to (rmw_dds_common).
#pragma once

#include <map>
#include <string>
#include <vector>

#include "overlay/dds/entity.h"
#include "overlay/ros2/ros_types.h"

namespace romano::ros2 {

class NodeGraph {
public:
    /// Throws DdsError.
    NodeGraph(const dds::Entity& participant, Release release);

    /// Told to others with the next tell().
    void add(const std::string& node, const dds::Entity& endpoint, bool writes);
    void clear();

    [[nodiscard]] bool has_changed() const { return changed_; }
    void tell();

private:
    struct Node {
        std::vector<dds_guid_t> readers;
        std::vector<dds_guid_t> writers;
    };

    template <typename Info, typename NodeInfo, typename Gid>
    void write() const;

    Release release_;
    dds_guid_t participant_{};
    dds::Entity topic_;
    dds::Entity writer_;
    std::map<std::string, Node> nodes_;
    bool changed_ = false;
};

}  // namespace romano::ros2
