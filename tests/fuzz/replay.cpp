// Runs a fuzz target without libFuzzer, as an ordinary test:
//
//     NAME_replay CORPUS...              over the files of its corpus
//     NAME_replay --mutate N CORPUS...   over N inputs made from them: octets changed, dropped,
//                                        repeated and added, by a fixed seed

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <string_view>
#include <vector>

#include "romano/base/random.h"

// NOLINTNEXTLINE(readability-identifier-naming): the name that libFuzzer calls
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

using Input = std::vector<std::uint8_t>;

constexpr std::size_t longest = 512;

std::vector<Input> read(const std::filesystem::path& folder) {
    std::vector<Input> inputs;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
        std::ifstream file(entry.path(), std::ios::binary);
        const std::vector<char> octets{std::istreambuf_iterator<char>(file), {}};
        inputs.emplace_back(octets.begin(), octets.end());
    }
    return inputs;
}

void mutate(Input& input, romano::Random& random) {
    const auto somewhere = [&] {
        const auto size = static_cast<std::uint32_t>(input.size());
        return input.begin() + static_cast<std::ptrdiff_t>(random.below(size));
    };
    for (std::uint32_t changes = 1 + random.below(4); changes > 0; --changes) {
        const auto octet = static_cast<std::uint8_t>(random.next());
        if (input.empty()) {
            input.push_back(octet);
            continue;
        }
        switch (random.below(5)) {
            case 0:
                *somewhere() = octet;
                break;
            case 1:
                *somewhere() ^= static_cast<std::uint8_t>(1U << random.below(8));
                break;
            case 2:
                input.erase(somewhere(), input.end());
                break;
            case 3:
                input.insert(somewhere(), octet);
                break;
            default: {
                const Input copy(somewhere(), input.end());
                input.insert(somewhere(), copy.begin(), copy.end());
                break;
            }
        }
    }
    if (input.size() > longest) input.resize(longest);
}

}  // namespace

int main(int argc, char** argv) {
    std::vector<Input> inputs;
    std::uint64_t mutations = 0;
    for (int i = 1; i < argc; ++i) {
        if (std::string_view{argv[i]} == "--mutate" && i + 1 < argc) {
            mutations = std::strtoull(argv[++i], nullptr, 10);
            continue;
        }
        for (Input& input : read(argv[i])) inputs.push_back(std::move(input));
    }
    if (inputs.empty()) return 1;
    if (mutations == 0) {
        for (const Input& input : inputs) LLVMFuzzerTestOneInput(input.data(), input.size());
        std::cout << inputs.size() << " inputs\n";
        return 0;
    }
    romano::Random random{1};
    for (std::uint64_t i = 0; i < mutations; ++i) {
        Input input = inputs[random.below(static_cast<std::uint32_t>(inputs.size()))];
        mutate(input, random);
        LLVMFuzzerTestOneInput(input.data(), input.size());
    }
    std::cout << mutations << " mutated inputs\n";
    return 0;
}
