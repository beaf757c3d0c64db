#include "experiments/sweep/csv.h"

#include <array>
#include <charconv>
#include <cmath>

namespace romano::experiments {

std::string csv_line(const CsvRow& fields) {
    std::string line;
    for (const std::string& field : fields) {
        if (&field != &fields.front()) line += ',';
        if (field.find_first_of(",\"\r\n") == std::string::npos) {
            line += field;
            continue;
        }
        line += '"';
        for (const char c : field) {
            if (c == '"') line += '"';
            line += c;
        }
        line += '"';
    }
    return line + '\n';
}

std::vector<CsvRow> parse_csv(std::string_view text) {
    std::vector<CsvRow> rows;
    CsvRow row;
    std::string field;
    bool quoted = false;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (quoted) {
            if (c != '"') {
                field += c;
            } else if (i + 1 < text.size() && text[i + 1] == '"') {
                field += '"';
                ++i;
            } else {
                quoted = false;
            }
        } else if (c == '"') {
            quoted = true;
        } else if (c == ',') {
            row.push_back(std::move(field));
            field.clear();
        } else if (c == '\n') {
            row.push_back(std::move(field));
            field.clear();
            rows.push_back(std::move(row));
            row.clear();
        } else if (c != '\r') {
            field += c;
        }
    }
    return rows;
}

std::string csv_number(double number) {
    std::array<char, 32> text{};
    // Counts without an exponent: readers of other languages take 9e+05 for no integer.
    const bool is_count = std::trunc(number) == number && std::abs(number) < 1e15;
    const auto format = is_count ? std::chars_format::fixed : std::chars_format::general;
    const auto end = std::to_chars(text.data(), text.data() + text.size(), number, format);
    return {text.data(), end.ptr};
}

std::optional<double> parse_csv_number(std::string_view field) {
    double number = 0;
    const auto end = std::from_chars(field.data(), field.data() + field.size(), number);
    if (end.ec != std::errc{} || end.ptr != field.data() + field.size()) return std::nullopt;
    return number;
}

}  // namespace romano::experiments
