// The quality of service of our topics, reader and writer alike.
//
// All keep the last N samples. A reliable writer that keeps all would block as soon as one reader
// stands still, and healthy readers would starve with it; this way a reader that is stopped for
// long loses samples, which the positions in them show, and nobody waits.
#pragma once

#include <dds/dds.h>

#include <cstdint>
#include <memory>

namespace romano::dds {

struct QosDeleter {
    void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
};
using Qos = std::unique_ptr<dds_qos_t, QosDeleter>;

[[nodiscard]] Qos best_effort(std::int32_t depth);
[[nodiscard]] Qos reliable(std::int32_t depth);
/// As reliable(); a reader that appears later gets the last `kept` samples that were written
/// before.
[[nodiscard]] Qos reliable_for_late_readers(std::int32_t depth, std::int32_t kept);

}  // namespace romano::dds
