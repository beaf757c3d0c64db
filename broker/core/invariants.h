// What must hold between the tables of a broker core after every step. Asserted, for tests and the
// simulator; never on the way of a datagram.
#pragma once

#include "broker/core/tables.h"

namespace romano::broker {

void check_invariants(const Tables& tables);

}  // namespace romano::broker
