// The machine that a sweep ran on: numbers mean little without it.
#pragma once

#include <string>

namespace romano::experiments {

struct Machine {
    std::string cpu;
    unsigned cores = 0;  // that this process may use
    double memory_gib = 0;
    std::string kernel;
    std::string system;       // the distribution's own name
    double load_average = 0;  // of the last minute: what else it had to do
};

[[nodiscard]] Machine this_machine();

}  // namespace romano::experiments
