// SIM_TRACE=1 in the environment: a scripted world tells on stderr what happens in it.
#pragma once

#include <cstdlib>
#include <iostream>
#include <string_view>

#include "overlay/sim/world.h"

namespace romano::sim {

inline void trace_if_asked(World& world) {
    if (std::getenv("SIM_TRACE") == nullptr) return;
    world.trace().listen([](std::string_view line) { std::cerr << line << '\n'; });
}

}  // namespace romano::sim
