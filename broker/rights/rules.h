// The rules of a rights file, which is written as mosquitto's acl_file is (README.md).
//
// Parsing is total: any text gives rules, or a line and what is wrong there.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "romano/base/result.h"

namespace romano::rights {

enum class Access : std::uint8_t {
    read,
    write,
    readwrite,
    deny,      // neither, whatever other rules say
    announce,  // publish what a robot tells of itself, in its own name
    loop,      // publish messages of control loops
};

struct Rule {
    Access access;
    std::string pattern;

    friend bool operator==(const Rule&, const Rule&) = default;
};

using RuleList = std::vector<Rule>;

// Groups that nobody is put into: whoever has a key is in one of the first two.
inline constexpr std::string_view robots = "robots";
inline constexpr std::string_view operators = "operators";
inline constexpr std::string_view plain = "plain";    // who has no key, at plain addresses
inline constexpr std::string_view uplink = "uplink";  // what comes over the uplink or from ROS 2

struct Rules {
    RuleList everybody;  // who has a key
    std::map<std::string, RuleList, std::less<>> groups;
    std::map<std::string, RuleList, std::less<>> users;
    std::map<std::string, std::set<std::string>, std::less<>> members;  // by group

    friend bool operator==(const Rules&, const Rules&) = default;
};

struct Fault {
    unsigned line = 0;  // from 1
    std::string what;
};

/// Where rights are set for all brokers, by those of the operators whom a rule lets: the text of a
/// rights file as a retained message, or an empty one, after which each broker has its own file's.
inline constexpr std::string_view rights_topic = "$ROMANO/rights";

inline constexpr std::size_t most_octets = std::size_t{1} << 20U;  // of a rights file

[[nodiscard]] Result<Rules, Fault> parse(std::string_view text);

/// What holds where nobody gave a rights file, as one that begins to be changed.
[[nodiscard]] std::string_view usual_rules();

/// The same for two files that differ in comments, blanks and the order of their sections: 16
/// hexadecimal digits.
[[nodiscard]] std::string digest_of(const Rules& rules);

}  // namespace romano::rights
