// ns-3's event list, which tells when its next event is: the public interface of the simulator does
// not, and its owner has to know up to when nothing happens in it.
#pragma once

#include <ns3/map-scheduler.h>

#include <cstdint>

namespace romano::lowpan {

class WatchedScheduler final : public ns3::MapScheduler {
public:
    static ns3::TypeId GetTypeId();
    WatchedScheduler() { current_ = this; }
    ~WatchedScheduler() override {
        if (current_ == this) current_ = nullptr;
    }

    /// Of the one simulator of this process; INT64_MAX: none.
    [[nodiscard]] static std::int64_t next_ns();

private:
    static WatchedScheduler* current_;  // ns-3 makes it itself, from its type's name
};

}  // namespace romano::lowpan
