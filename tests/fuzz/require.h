// What a fuzz target requires to be true; a failure ends the process, where libFuzzer sees it.
#pragma once

#include <cstdio>
#include <cstdlib>

#define REQUIRE(condition)                                                                 \
    do {                                                                                   \
        if (!(condition)) {                                                                \
            std::fprintf(stderr, "%s:%d: not true: " #condition "\n", __FILE__, __LINE__); \
            std::abort();                                                                  \
        }                                                                                  \
    } while (false)
