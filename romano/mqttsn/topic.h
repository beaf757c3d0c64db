// Topic names and filters: MQTT's rules, to which MQTT-SN 1.2 section 6 leaves them.
#pragma once

#include <string_view>

namespace romano::mqttsn {

/// At least one octet, well-formed UTF-8, no U+0000, no wildcard [MQTT 3.1.1 4.7.3, 1.5.3].
[[nodiscard]] bool is_valid_topic_name(std::string_view name);

/// As a name, but '+' may fill a whole level and '#' the last one [MQTT 3.1.1 4.7.1].
[[nodiscard]] bool is_valid_topic_filter(std::string_view filter);

/// True when a valid filter holds a wildcard.
[[nodiscard]] bool has_wildcard(std::string_view filter);

/// Both must be valid. '#' matches the parent level too; a filter that begins with a wildcard does
/// not match names that begin with '$' [MQTT 3.1.1 4.7.2].
[[nodiscard]] bool matches(std::string_view filter, std::string_view name);

}  // namespace romano::mqttsn
