// The include rule of the architecture: the wire ring, the cores and the shells include only
// inwards. Reads the #include lines of the tree; see the table for who may include whom.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;
using Folders = std::vector<std::string>;

// Who may include whom. A folder may always include itself. "*" means every folder of the project.
const std::map<std::string, Folders>& allowed() {
    static const std::map<std::string, Folders> table = {
        // wire and floor
        {"romano/base", {}},
        {"romano/mqttsn", {"romano/base"}},
        {"romano/message", {"romano/base"}},
        {"firmware/hdlc", {"romano/base"}},
        // cores
        {"election", {"romano/base"}},
        {"romano/protection", {"romano/base", "romano/mqttsn"}},
        {"romano/dtls/record", {"romano/base", "romano/protection"}},
        {"romano/client", {"romano/base", "romano/mqttsn"}},
        {"broker/core", {"romano/base", "romano/mqttsn"}},
        {"broker/protection", {"romano/base", "romano/mqttsn", "romano/protection", "broker/core"}},
        {"broker/dtls",
         {"romano/base", "romano/mqttsn", "romano/protection", "romano/dtls/record", "broker/core",
          "broker/protection"}},
        {"broker/rights",
         {"romano/base", "romano/mqttsn", "romano/message", "romano/control", "romano/protection",
          "broker/core", "broker/protection"}},
        {"broker/uplink", {"romano/base", "romano/mqttsn", "broker/core"}},
        {"romano/server", {"romano/base", "romano/message"}},
        {"broker/server", {"romano/base", "romano/mqttsn", "romano/server", "broker/core"}},
        {"romano/node", {"romano/base", "romano/mqttsn", "romano/message", "romano/client"}},
        {"romano/control", {"romano/base", "romano/mqttsn", "romano/message"}},
        {"overlay/cluster", {"romano/base", "romano/mqttsn", "election", "broker/core"}},
        {"overlay",  // transport.h, packets_told.h
         {"romano/base", "romano/protection", "romano/dtls/record", "broker/core",
          "broker/protection", "broker/dtls", "election", "overlay/cluster"}},
        {"overlay/member",
         {"romano/base", "romano/mqttsn", "election", "broker/core", "broker/server",
          "broker/uplink", "overlay", "overlay/cluster"}},
        {"overlay/ros2", {"romano/base", "romano/mqttsn", "romano/message"}},
        // shells
        {"romano/dtls",
         {"romano/base", "romano/mqttsn", "romano/protection", "romano/dtls/record"}},
        {"romano/keys", {"romano/base", "romano/mqttsn", "romano/protection", "romano/dtls"}},
        {"romano/cli", {}},
        {"broker/dtls/openssl",
         {"romano/base", "romano/mqttsn", "romano/protection", "romano/dtls", "romano/dtls/record",
          "broker/core", "broker/protection", "broker/dtls"}},
        {"broker/net", {"romano/base", "romano/mqttsn", "broker/core"}},
        {"broker/uplink/mqtt",
         {"romano/base", "romano/mqttsn", "broker/core", "broker/net", "broker/uplink"}},
        {"broker/https", {"romano/keys"}},
        {"broker/metrics",
         {"romano/base", "romano/mqttsn", "broker/core", "broker/https", "broker/net"}},
        {"broker/store", {"romano/base", "romano/mqttsn", "broker/core", "broker/net"}},
        {"overlay/dds",
         {"romano/base", "romano/mqttsn", "election", "broker/core", "overlay", "overlay/cluster"}},
        {"overlay/link", {"romano/base", "election", "broker/core", "broker/net"}},
        {"overlay/ros2/dds",
         {"romano/base", "romano/mqttsn", "broker/core", "broker/uplink", "broker/net",
          "overlay/dds", "overlay/ros2"}},
        {"overlay/sim",
         {"romano/base", "romano/mqttsn", "romano/protection", "romano/dtls/record",
          "romano/client", "election", "broker/core", "broker/protection", "broker/dtls",
          "broker/rights", "overlay", "overlay/cluster", "overlay/member"}},
        {"overlay/radio", {"romano/base", "firmware/hdlc", "overlay/sim"}},
        // the fleet's picture, a core among programs
        {"experiments/fleet",
         {"romano/base", "romano/mqttsn", "romano/message", "romano/server", "romano/control",
          "experiments"}},
        // the file format of recordings, a core too
        {"experiments/mcap", {"romano/base"}},
        // programs
        {"broker/daemon",
         {"romano/base", "romano/mqttsn", "romano/protection", "romano/keys", "election",
          "broker/core", "broker/protection", "broker/dtls", "broker/dtls/openssl", "broker/rights",
          "broker/server", "broker/uplink", "broker/uplink/mqtt", "broker/https", "broker/net",
          "broker/metrics", "broker/store"}},
        {"overlay/daemon",
         {"romano/base", "romano/keys", "election", "broker/core", "broker/uplink",
          "broker/uplink/mqtt", "broker/net", "broker/metrics", "broker/daemon", "overlay",
          "overlay/cluster", "overlay/member", "overlay/dds", "overlay/link", "overlay/ros2",
          "overlay/ros2/dds"}},
        {"experiments", {"*"}},
        {"firmware", {"*"}},
        {"bench", {"*"}},
    };
    return table;
}

// Folders whose code has no heap, clock, thread, file or socket of its own.
const std::set<std::string>& cores() {
    static const std::set<std::string> folders = {
        "romano/base",       "romano/mqttsn",     "romano/message",   "romano/protection",
        "romano/client",     "romano/node",       "romano/control",   "romano/server",
        "election",          "broker/core",       "broker/server",    "broker/uplink",
        "broker/protection", "broker/rights",     "overlay/cluster",  "overlay/member",
        "overlay/ros2",      "experiments/fleet", "experiments/mcap", "broker/dtls",
        "romano/dtls/record"};
    return folders;
}

const std::regex& poison() {
    static const std::regex pattern(
        "boost/.*|asio.*|mosquitto\\.h|prometheus/.*|google/protobuf/.*|dds/.*|sqlite3\\.h|spdlog/"
        ".*|sys/"
        ".*|netinet/.*|arpa/.*|unistd\\.h|"
        "thread|mutex|condition_variable|future|fstream|iostream|filesystem|random");
    return pattern;
}

struct Include {
    fs::path file;
    int line;
    std::string target;
};

std::string folder_of(const std::string& path) {
    std::string folder = fs::path(path).parent_path().generic_string();
    while (!folder.empty() && !allowed().contains(folder)) {
        folder = fs::path(folder).parent_path().generic_string();
    }
    return folder;
}

std::vector<Include> includes_of_the_tree() {
    const fs::path root = ROMANO_SOURCE_DIR;
    const std::regex include_line(R"(^\s*#\s*include\s*[<"]([^>"]+)[>"])");
    std::vector<Include> found;
    for (const std::string top :
         {"romano", "election", "broker", "overlay", "firmware", "experiments", "bench"}) {
        for (const auto& entry : fs::recursive_directory_iterator(root / top)) {
            const std::string extension = entry.path().extension().string();
            if (extension != ".h" && extension != ".cpp") continue;
            std::ifstream text(entry.path());
            std::string line;
            for (int number = 1; std::getline(text, line); ++number) {
                std::smatch match;
                if (std::regex_search(line, match, include_line)) {
                    found.push_back({fs::relative(entry.path(), root), number, match[1]});
                }
            }
        }
    }
    return found;
}

bool is_project_path(const std::string& target) {
    const std::string top = target.substr(0, target.find('/'));
    static const std::set<std::string> tops = {"romano",   "election",    "broker", "overlay",
                                               "firmware", "experiments", "bench",  "tests"};
    return target.find('/') != std::string::npos && tops.contains(top);
}

TEST(Arrows, IncludesPointInwardsOnly) {
    const auto includes = includes_of_the_tree();
    ASSERT_FALSE(includes.empty());
    for (const auto& include : includes) {
        if (!is_project_path(include.target)) continue;
        const std::string from = folder_of(include.file.generic_string());
        const std::string to = folder_of(include.target);
        ASSERT_FALSE(from.empty())
            << include.file << ": its folder is missing in the table of arrows";
        const Folders& may = allowed().at(from);
        const bool fine =
            from == to || std::ranges::count(may, "*") > 0 || std::ranges::count(may, to) > 0;
        EXPECT_TRUE(fine) << include.file.string() << ":" << include.line << " includes \""
                          << include.target << "\", but " << from << " may not see "
                          << (to.empty() ? "that" : to);
    }
}

TEST(Arrows, CoresIncludeNoInputOutput) {
    for (const auto& include : includes_of_the_tree()) {
        if (!cores().contains(folder_of(include.file.generic_string()))) continue;
        EXPECT_FALSE(std::regex_match(include.target, poison()))
            << include.file.string() << ":" << include.line << " includes <" << include.target
            << ">: a core has no sockets, clocks, threads or files";
    }
}

TEST(Arrows, CoresNeverReadAClock) {
    const fs::path root = ROMANO_SOURCE_DIR;
    const std::regex clock(
        R"((steady_clock|system_clock|high_resolution_clock)::now|clock_gettime)");
    for (const std::string& core : cores()) {
        if (!fs::exists(root / core)) continue;
        for (const auto& entry : fs::recursive_directory_iterator(root / core)) {
            if (!entry.is_regular_file()) continue;
            std::ifstream text(entry.path());
            const std::string whole{std::istreambuf_iterator<char>(text), {}};
            EXPECT_FALSE(std::regex_search(whole, clock)) << entry.path() << " reads a clock";
        }
    }
}

TEST(Arrows, IncludesAreRootedAtTheRepository) {
    const fs::path root = ROMANO_SOURCE_DIR;
    for (const auto& include : includes_of_the_tree()) {
        if (include.target.find('/') != std::string::npos) continue;
        const fs::path sibling = root / include.file.parent_path() / include.target;
        EXPECT_FALSE(fs::exists(sibling))
            << include.file.string() << ":" << include.line << " includes \"" << include.target
            << "\" without its folder";
    }
}

TEST(Arrows, NobodyUsesViewsOfRanges) {  // Clang 14 cannot compile those of GCC 12's library
    for (const auto& include : includes_of_the_tree()) {
        EXPECT_NE(include.target, "ranges") << include.file.string() << ":" << include.line;
    }
}

}  // namespace
