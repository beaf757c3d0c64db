// A real romano-broker process.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/system/process.h"

namespace romano::system {

class BrokerProcess : public Process {
public:
    explicit BrokerProcess(const std::vector<std::string>& arguments)
        : Process(ROMANO_BROKER, arguments) {}

    /// Waits for "... serving ..."; a test failure, with the broker's own words, when it does not
    /// come.
    void wait_until_serving() {
        const std::string line = next_line();
        ASSERT_NE(line.find("serving"), std::string::npos) << line << errors();
    }
};

}  // namespace romano::system
