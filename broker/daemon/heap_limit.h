// The one bound on all memory together (--max-memory-mb): what the process holds of the heap.
//
// Counted where it is true, in operator new and delete: exact at any moment, and for a few
// nanoseconds each. What C libraries take for themselves (DDS, SQLite, TLS) is not in it.
#pragma once

#include <cstddef>

#include "broker/metrics/page.h"

namespace romano::daemon {

class HeapLimit {
public:
    explicit HeapLimit(std::size_t mib) : most_(mib << 20U) {}

    /// True from the limit on until a sixteenth of it is free again; says so when it changes.
    bool is_reached();
    void add_metrics(metrics::Page& page) const;

    [[nodiscard]] static std::size_t octets_in_use();

private:
    std::size_t most_;
    bool reached_ = false;
};

}  // namespace romano::daemon
