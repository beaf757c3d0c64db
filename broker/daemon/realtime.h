// Runs this process before others, so that its beacons leave and its timers fire on time though the
// machine is busy.
#pragma once

namespace romano::daemon {

/// SCHED_RR for this thread and those that it starts from now on, and memory that stays resident.
/// Throws Refusal when the system does not permit it.
void become_realtime();

}  // namespace romano::daemon
