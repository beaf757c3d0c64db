// The bridge's end in a ROS 2 domain: one participant, publishers and subscriptions as they are
// wanted, the nodes that they belong to, and what publishers others have.
//
// The participant is there from the beginning, so that the other side is known when the bridge is
// opened; endpoints and nodes are there only while it is. Owned and called by one thread; DDS's own
// threads only call `on_ready`.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "overlay/dds/domain.h"
#include "overlay/dds/entity.h"
#include "overlay/ros2/bridge_core.h"
#include "overlay/ros2/dds/node_graph.h"

namespace romano::ros2 {

struct RosSettings {
    std::uint32_t domain = 0;
    std::string interface;  // empty: DDS chooses
    bool over_ipv6 = false;
    Release release = Release::iron;
};

/// Somebody else's publisher.
struct RosWriter {
    std::string topic;
    std::string type;  // as ROS 2 names it
    bool reliable = false;
    bool retained = false;
    bool of_a_bridge = false;
};

struct RosSample {
    const std::string& topic;
    RosMessage message;
    std::string identity;  // the same wherever it is read
};

class RosSide {
public:
    static constexpr std::size_t most_at_once = 16;
    static constexpr std::size_t most_writers = 20'000;  // of others, that are remembered

    /// `on_ready`: there is something to take. Throws DdsError.
    RosSide(const RosSettings& settings, std::function<void()> on_ready);
    ~RosSide();
    RosSide(const RosSide&) = delete;
    RosSide& operator=(const RosSide&) = delete;

    /// Throws DdsError.
    void make(const MakeEndpoint& endpoint);
    /// False when DDS did not take it.
    bool write(const std::string& topic, const RosMessage& message);
    /// All endpoints and nodes go.
    void close();

    [[nodiscard]] NodeGraph& nodes() { return nodes_; }

    /// Those that came since the last call.
    [[nodiscard]] std::vector<RosWriter> new_writers();
    [[nodiscard]] std::vector<RosWriter> writers() const;
    /// Takes some samples of each reader that has any; true when there may be more.
    bool take(const std::function<void(RosSample)>& on_sample);

private:
    struct Ready;
    struct Endpoint {
        RosType type{};
        dds::Entity topic;
        dds::Entity endpoint;
    };
    struct Origin {
        std::string guid;
        bool of_a_bridge = false;
    };

    [[nodiscard]] const Origin& origin_of(dds_entity_t reader, dds_instance_handle_t writer);
    [[nodiscard]] std::string name_of(const dds_sample_info_t& info);
    void take_from(dds_entity_t reader, const std::function<void(RosSample)>& on_sample,
                   bool& more);

    Release release_;
    std::unique_ptr<Ready> ready_;
    dds::Domain domain_;
    dds::Entity participant_;
    dds_guid_t self_{};
    NodeGraph nodes_;
    dds::Entity publications_;                 // the reader of DCPSPublication
    std::map<std::string, RosWriter> others_;  // by guid
    std::map<std::string, Endpoint> writers_;  // by ROS 2 topic
    std::map<std::string, Endpoint> readers_;
    std::map<dds_entity_t, std::string> topics_of_readers_;
    std::map<dds_instance_handle_t, Origin> origins_;
    std::uint64_t without_stamp_ = 0;  // samples
};

}  // namespace romano::ros2
