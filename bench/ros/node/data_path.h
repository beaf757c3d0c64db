// A node's way to other nodes: topics and messages, and nothing of what carries them. There is a
// program for each, which links one implementation with node.cpp.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "romano/base/bytes.h"
#include "romano/base/time.h"

namespace romano::bench::ros {

struct NodePlan {
    std::string name;
    std::string address;                 // of this machine, IPv4
    std::string infrastructure;          // address of the ROS 1 master, or of the broker; or empty
    bool reliable = true;                // else what is lost is lost
    std::vector<std::string> publishes;  // topics: letters and digits
    std::vector<std::string> subscribes;
};

class DataPath {
public:
    /// On the thread that calls turn().
    using OnMessage = std::function<void(Bytes payload)>;

    DataPath() = default;
    virtual ~DataPath() = default;
    DataPath(const DataPath&) = delete;
    DataPath& operator=(const DataPath&) = delete;

    /// On the plan's topic of that number. What cannot be sent now is lost, or waits, as the path
    /// has it.
    virtual void publish(std::size_t topic, Bytes payload) = 0;
    /// Hands over what has come; waits for it until `until` at most.
    virtual void turn(Instant until) = 0;
};

/// Joins; goes on trying where infrastructure is missing. Throws std::exception.
[[nodiscard]] std::unique_ptr<DataPath> make_data_path(const NodePlan& plan,
                                                       DataPath::OnMessage on_message);

}  // namespace romano::bench::ros
