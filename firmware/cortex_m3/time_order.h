// Included before all else in the image. For two time points libstdc++ 12 prefers its operator<=>
// to its operator<, and so makes a call and a second comparison of each comparison; these are
// better matches.
#pragma once

#include "romano/base/time.h"

namespace romano {

constexpr bool operator<(Instant a, Instant b) {
    return a.time_since_epoch().count() < b.time_since_epoch().count();
}
constexpr bool operator<=(Instant a, Instant b) {
    return a.time_since_epoch().count() <= b.time_since_epoch().count();
}

}  // namespace romano
