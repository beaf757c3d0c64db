// Runs a fuzz target without libFuzzer, as an ordinary test:
//
//     NAME_replay CORPUS                   over the inputs of its corpus
//     NAME_replay --mutate N CORPUS        over N inputs made from them: octets changed, dropped,
//                                          repeated and added, by a fixed seed
//     NAME_replay --unpack FOLDER CORPUS   writes each input into a file there, for libFuzzer
//
// A corpus is a text file: one input a line, two hexadecimal digits an octet.

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <string>
#include <string_view>
#include <vector>

#include "romano/base/random.h"

// NOLINTNEXTLINE(readability-identifier-naming): the name that libFuzzer calls
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

using Input = std::vector<std::uint8_t>;

constexpr std::size_t longest = 512;

int digit(char c) {
    const std::string_view digits = "0123456789abcdef";
    const std::size_t at = digits.find(c);
    return at == std::string_view::npos ? -1 : static_cast<int>(at);
}

/// Ends the process, with a sentence, when the file is no corpus.
std::vector<Input> read(const std::filesystem::path& path) {
    std::ifstream file(path);
    if (!file) {
        std::cerr << path << ": cannot be read\n";
        std::exit(1);
    }
    std::vector<Input> inputs;
    for (std::string line; std::getline(file, line);) {
        Input& input = inputs.emplace_back();
        for (std::size_t i = 0; i < line.size(); i += 2) {
            const int high = digit(line[i]);
            const int low = i + 1 < line.size() ? digit(line[i + 1]) : -1;
            if (high < 0 || low < 0) {
                std::cerr << path << ": line " << inputs.size()
                          << " is not of pairs of hexadecimal digits\n";
                std::exit(1);
            }
            input.push_back(static_cast<std::uint8_t>(high << 4 | low));
        }
    }
    return inputs;
}

void unpack(const std::vector<Input>& inputs, const std::filesystem::path& folder) {
    std::filesystem::create_directories(folder);
    for (std::size_t i = 0; i < inputs.size(); ++i) {
        std::ofstream file(folder / std::to_string(i), std::ios::binary);
        for (const std::uint8_t octet : inputs[i]) file.put(static_cast<char>(octet));
    }
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
    const std::vector<std::string_view> arguments(argv + 1, argv + argc);
    const bool has_option = arguments.size() == 3;
    if (arguments.size() != 1 && !has_option) return 2;
    const std::vector<Input> inputs = read(arguments.back());
    if (inputs.empty()) return 1;
    if (has_option && arguments[0] == "--unpack") {
        unpack(inputs, arguments[1]);
        return 0;
    }
    if (has_option && arguments[0] != "--mutate") return 2;
    if (!has_option) {
        for (const Input& input : inputs) LLVMFuzzerTestOneInput(input.data(), input.size());
        std::cout << inputs.size() << " inputs\n";
        return 0;
    }
    const std::uint64_t mutations = std::strtoull(argv[2], nullptr, 10);
    romano::Random random{1};
    for (std::uint64_t i = 0; i < mutations; ++i) {
        Input input = inputs[random.below(static_cast<std::uint32_t>(inputs.size()))];
        mutate(input, random);
        LLVMFuzzerTestOneInput(input.data(), input.size());
    }
    std::cout << mutations << " mutated inputs\n";
    return 0;
}
