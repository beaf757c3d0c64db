#include "bench/ros/neighbour_room.h"

#include <fstream>

namespace romano::bench::ros {
namespace {

constexpr long enough = 16'384;

}  // namespace

// Of gc_thresh1, 2 and 3 the last is the one that refuses entries (arp(7)); beyond the others old
// ones are looked for, which takes time.
NeighbourRoom::NeighbourRoom() {
    for (const char* name : {"gc_thresh3", "gc_thresh2", "gc_thresh1"}) {
        const std::string file = std::string("/proc/sys/net/ipv4/neigh/default/") + name;
        long before = 0;
        if (!(std::ifstream(file) >> before) || before >= enough) continue;
        std::ofstream out(file);
        if ((out << enough).flush()) raised_.push_back({file, before});
    }
}

NeighbourRoom::~NeighbourRoom() {
    for (auto bound = raised_.rbegin(); bound != raised_.rend(); ++bound) {
        std::ofstream(bound->file) << bound->before;
    }
}

}  // namespace romano::bench::ros
