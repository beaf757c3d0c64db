// Matching against MQTT 3.1.1 section 4.7 written down a second time, level by level.

#include "romano/mqttsn/topic.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "romano/base/bytes.h"
#include "tests/fuzz/require.h"

using namespace romano;
using namespace romano::mqttsn;

namespace {

std::vector<std::string_view> levels_of(std::string_view text) {
    std::vector<std::string_view> levels;
    for (;;) {
        const std::size_t slash = text.find('/');
        levels.push_back(text.substr(0, slash));
        if (slash == std::string_view::npos) return levels;
        text.remove_prefix(slash + 1);
    }
}

bool matches_by_levels(std::string_view filter, std::string_view name) {
    const auto wanted = levels_of(filter);
    const auto given = levels_of(name);
    if (name.starts_with('$') && (wanted[0] == "+" || wanted[0] == "#")) return false;
    for (std::size_t i = 0; i < wanted.size(); ++i) {
        if (wanted[i] == "#") return true;
        if (i == given.size()) return false;
        if (wanted[i] != "+" && wanted[i] != given[i]) return false;
    }
    return wanted.size() == given.size();
}

bool is_filter_by_levels(std::string_view filter) {
    const auto levels = levels_of(filter);
    for (std::size_t i = 0; i < levels.size(); ++i) {
        if (levels[i] == "#" && i + 1 == levels.size()) continue;
        if (levels[i] == "+") continue;
        if (levels[i].find_first_of("+#") != std::string_view::npos) return false;
    }
    return true;
}

}  // namespace

/// The first octet says how much of the rest is the filter; what follows is the name.
// NOLINTNEXTLINE(readability-identifier-naming): the name that libFuzzer calls
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size == 0) return 0;
    const std::string_view text = as_text({data + 1, size - 1});
    const std::string_view filter = text.substr(0, data[0]);
    const std::string_view name = text.substr(filter.size());

    if (is_valid_topic_filter(filter)) REQUIRE(is_filter_by_levels(filter));
    if (is_valid_topic_name(name)) {
        REQUIRE(!has_wildcard(name));
        REQUIRE(is_valid_topic_filter(name));
        REQUIRE(matches(name, name));
        if (is_valid_topic_filter(filter)) {
            REQUIRE(matches(filter, name) == matches_by_levels(filter, name));
        }
    }
    return 0;
}
