// Runs the real programs for a test: romano, and brokers on loopback addresses of the test's own.
#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "experiments/process/broker_process.h"
#include "tests/temporary_folder.h"

namespace romano::experiments {

struct Ran {
    int exit_code = -1;
    std::string output;  // both streams
};

/// `romano <arguments>`, through the shell.
inline Ran run_romano(const std::string& arguments) {
    const std::string command = std::string{ROMANO_PROGRAM} + " 2>&1 " + arguments;
    Ran ran;
    std::FILE* output = ::popen(command.c_str(), "r");
    if (output == nullptr) return ran;
    std::array<char, 4096> part{};
    while (const std::size_t size = std::fread(part.data(), 1, part.size(), output)) {
        ran.output.append(part.data(), size);
    }
    const int status = ::pclose(output);
    if (WIFEXITED(status)) ran.exit_code = WEXITSTATUS(status);
    return ran;
}

/// Tests that run at the same time have other ports.
inline std::string own_port() {
    return std::to_string(20'000 + ::getpid() % 10'000);
}

/// A lone broker that serves when the constructor returns.
class ServingBroker {
public:
    explicit ServingBroker(const std::string& address, const std::vector<std::string>& more = {}) {
        std::vector<std::string> arguments = {"--name",    "b1",
                                              "--listen",  address + ":" + own_port(),
                                              "--metrics", address + ":" + own_port()};
        arguments.insert(arguments.end(), more.begin(), more.end());
        process_ = std::make_unique<BrokerProcess>("b1", BROKER_PROGRAM, arguments, trace_);
        // It prints a line when it serves.
        for (int i = 0; i < 2000 && !is_serving(); ++i) {
            std::this_thread::sleep_for(std::chrono::milliseconds{5});
        }
    }

private:
    [[nodiscard]] bool is_serving() const {
        std::ifstream trace(trace_);
        const std::string text{std::istreambuf_iterator<char>(trace), {}};
        return text.find("serving") != std::string::npos;
    }

    tests::TemporaryFolder folder_;
    std::filesystem::path trace_ = folder_ / "trace";
    std::unique_ptr<BrokerProcess> process_;
};

}  // namespace romano::experiments
