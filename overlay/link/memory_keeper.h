// Keeps this process's memory for a moment longer than the process, so that its connections end at
// once when it dies.
//
// The kernel frees the memory of a dead process before it closes its files: milliseconds, tens of
// them when a broker has many sessions, on a processor that the survivors need. Unless somebody
// else has the same memory. So a second process has it, does nothing, and ends when all is over, in
// time that nobody else wants.
//
// It has no memory of its own, and no files; `ps` calls it romano-memory. Without it (no room for
// another process, or somebody killed it) connections end as late as the kernel closes them.
#pragma once

#include <sys/types.h>

namespace romano::link {

class MemoryKeeper {
public:
    /// On a thread that lives as long as the process.
    MemoryKeeper();
    ~MemoryKeeper();
    MemoryKeeper(const MemoryKeeper&) = delete;
    MemoryKeeper& operator=(const MemoryKeeper&) = delete;

    /// Not where the machine has no room for another process, nor under QEMU's user mode.
    [[nodiscard]] bool was_started() const { return process_ > 0; }

private:
    void* stack_ = nullptr;
    pid_t process_ = -1;
};

}  // namespace romano::link
