// What a gate is made of, for settings.
#pragma once

#include <filesystem>

namespace romano::https {

/// Files that nobody but their owner may read.
struct GateFiles {
    std::filesystem::path certificate;  // and its private key, PEM
    std::filesystem::path token;
};

}  // namespace romano::https
