// Prometheus's conventions for the names on a page of metrics.
#pragma once

#include <gtest/gtest.h>

#include <regex>
#include <set>
#include <sstream>
#include <string>

namespace romano::metrics {

/// Each family once, ours by their first word, counters by their last.
inline void expect_conventional_names(const std::string& page) {
    std::istringstream lines(page);
    std::set<std::string> families;
    std::string line;
    const std::regex type_line(R"(# TYPE (\S+) (\S+))");
    const std::regex sample(R"(([a-z_][a-z0-9_]*)(\{[^}]*\})? [-+0-9.e]+)");
    while (std::getline(lines, line)) {
        std::smatch match;
        if (std::regex_match(line, match, type_line)) {
            const std::string name = match[1];
            EXPECT_TRUE(families.insert(name).second) << name << " comes twice";
            EXPECT_TRUE(name.starts_with("romano_") || name.starts_with("process_")) << name;
            EXPECT_TRUE(match[2] != "counter" || name.ends_with("_total")) << name;
        } else if (!line.starts_with("# HELP ")) {
            EXPECT_TRUE(std::regex_match(line, sample)) << line;
        }
    }
}

}  // namespace romano::metrics
