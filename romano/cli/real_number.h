// A number with a decimal point in a range, as an option's value. CLI::Range lets "nan" through,
// for it compares as neither too small nor too large.
#pragma once

#include <CLI/CLI.hpp>
#include <sstream>
#include <string>

namespace romano {

[[nodiscard]] inline CLI::Validator real_number(double low, double high) {
    const auto words = [&](const char* before, const char* between) {
        std::ostringstream out;
        out << before << low << between << high;
        return out.str();
    };
    return {[low, high, range = words("", " to ")](const std::string& text) -> std::string {
                double value = 0;
                const bool is_inside =
                    CLI::detail::lexical_cast(text, value) && value >= low && value <= high;
                return is_inside ? "" : "Value " + text + " not in range " + range;
            },
            words("FLOAT in [", " - ") + "]"};
}

}  // namespace romano
