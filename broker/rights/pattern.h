// Patterns of a rights file: topic filters of which a whole level may be `%i`, the client's own id.
//
// Nothing is copied: the id stands in for the level while it is compared. It is one level and no
// wildcard, whatever octets it has; an empty one, and one that begins with '$', is no level at all.
#pragma once

#include <string_view>

namespace romano::rights {

inline constexpr std::string_view own_id = "%i";

/// A valid topic filter, and where `%i` stands it fills its level.
[[nodiscard]] bool is_valid_pattern(std::string_view pattern);

/// The topic is one of the pattern's [MQTT 3.1.1 4.7]: no pattern that begins with a wildcard has
/// topics that begin with '$'.
[[nodiscard]] bool matches(std::string_view pattern, std::string_view id, std::string_view topic);

/// All topics of the filter are the pattern's.
[[nodiscard]] bool covers(std::string_view pattern, std::string_view id, std::string_view filter);

/// Some topic is both the pattern's and the filter's.
[[nodiscard]] bool overlaps(std::string_view pattern, std::string_view id, std::string_view filter);

}  // namespace romano::rights
