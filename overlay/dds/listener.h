// A listener of Cyclone DDS that rings when there is something to take.
#pragma once

#include <dds/dds.h>

#include <memory>

#include "overlay/dds/wakeup.h"

namespace romano::dds {

struct ListenerDeleter {
    void operator()(dds_listener_t* listener) const { dds_delete_listener(listener); }
};
using Listener = std::unique_ptr<dds_listener_t, ListenerDeleter>;

/// `wakeup` must outlive the reader that is made with it. DDS copies the listener.
inline Listener ringing(Wakeup& wakeup) {
    Listener listener{dds_create_listener(&wakeup)};
    dds_lset_data_available(listener.get(),
                            [](dds_entity_t, void* to) { static_cast<Wakeup*>(to)->ring(); });
    return listener;
}

}  // namespace romano::dds
