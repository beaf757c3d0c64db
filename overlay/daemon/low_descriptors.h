// Cyclone DDS waits for its sockets with select(), which aborts the process at a descriptor of
// FD_SETSIZE (1,024) or more. Ours are few and bounded, and DDS takes its own before clients, links
// and metrics come; but whoever starts a broker may leave it his.
#pragma once

namespace romano::daemon {

/// Throws Refusal when too few descriptors are free below FD_SETSIZE. To be called before DDS.
void expect_low_descriptors();

}  // namespace romano::daemon
