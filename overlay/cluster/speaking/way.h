// The way of a client's datagrams: where they come from, and to which service address. Two clients
// may be at one address, but on one way there is one (broker/core/session_table.h).
#pragma once

#include <compare>

#include "romano/base/endpoint.h"

namespace romano::cluster {

struct Way {
    Endpoint via;
    Endpoint from;

    friend auto operator<=>(const Way&, const Way&) = default;
};

}  // namespace romano::cluster
