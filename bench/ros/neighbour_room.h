// Room for the neighbours of many machines. All network namespaces of a machine share the kernel's
// table, and 51 nodes that all talk to each other have 2,550 entries; Linux keeps 1,024.
#pragma once

#include <string>
#include <vector>

namespace romano::bench::ros {

/// While it lives the bounds are higher, for the whole machine; then they are as before.
class NeighbourRoom {
public:
    NeighbourRoom();
    ~NeighbourRoom();
    NeighbourRoom(const NeighbourRoom&) = delete;
    NeighbourRoom& operator=(const NeighbourRoom&) = delete;

private:
    struct Bound {
        std::string file;
        long before = 0;
    };
    std::vector<Bound> raised_;
};

}  // namespace romano::bench::ros
