#include "experiments/sweep/toml_table.h"

#include <cmath>
#include <sstream>

namespace romano::experiments {
namespace {

/// The value as the file has it: 12, "kill", [1, 2].
std::string as_written(const toml::node& node) {
    std::ostringstream text;
    if (node.is_table() || node.is_array_of_tables()) return "a table";
    if (const auto word = node.value_exact<std::string>()) return '"' + *word + '"';
    node.visit([&text](const auto& value) { text << value; });
    return text.str();
}

}  // namespace

std::string listed(std::span<const std::string_view> names) {
    std::string text;
    for (const std::string_view name : names) {
        if (!text.empty()) text += ", ";
        text += name;
    }
    return text;
}

toml::table parse_toml(std::string_view text, const std::string& file_name) {
    try {
        return toml::parse(text, file_name);
    } catch (const toml::parse_error& error) {
        throw SettingError(file_name + ", line " + std::to_string(error.source().begin.line) +
                           ": no TOML: " + std::string{error.description()});
    }
}

void TomlTable::refuse(const toml::node& node, const std::string& setting,
                       const std::string& allowed) const {
    throw SettingError(where(node.source()) + "`" + section_ + setting + " = " + as_written(node) +
                       "`: " + allowed);
}

void TomlTable::allow_only(std::span<const std::string_view> keys) const {
    for (const auto& [key, node] : table_) {
        if (std::ranges::find(keys, key.str()) != keys.end()) continue;
        throw SettingError(where(key.source()) + "unknown setting `" + section_ +
                           std::string{key.str()} + "`; known are " + listed(keys));
    }
}

std::int64_t TomlTable::integer(const std::string& key, std::int64_t fallback, std::int64_t low,
                                std::int64_t high) const {
    const toml::node* node = find(key);
    return node == nullptr ? fallback : integer_in(*node, key, low, high);
}

std::int64_t TomlTable::integer_in(const toml::node& node, const std::string& key, std::int64_t low,
                                   std::int64_t high) const {
    const auto value = node.value_exact<std::int64_t>();
    if (!value || *value < low || *value > high) {
        refuse(node, key,
               "a whole number from " + std::to_string(low) + " to " + std::to_string(high) +
                   " is allowed");
    }
    return *value;
}

double TomlTable::number_in(const toml::node& node, const std::string& key, double low, double high,
                            const char* allowed) const {
    const auto value = node.value<double>();
    if (!node.is_number() || !std::isfinite(*value) || *value < low || *value > high) {
        refuse(node, key, allowed);
    }
    return *value;
}

TomlTable::Seconds TomlTable::seconds(const std::string& key, Seconds fallback) const {
    const toml::node* node = find(key);
    if (node == nullptr) return fallback;
    return Seconds{number_in(*node, key, 0, 86400, "seconds from 0 to 86400 are allowed")};
}

std::vector<std::string> TomlTable::words(const std::string& key,
                                          const std::vector<std::string>& fallback) const {
    const toml::node* node = find(key);
    if (node == nullptr) return fallback;
    const toml::array* list = node->as_array();
    if (list == nullptr) refuse(*node, key, "a list of texts is allowed");
    std::vector<std::string> words;
    for (const toml::node& item : *list) {
        const auto value = item.value_exact<std::string>();
        if (!value) refuse(item, key, "a list of texts is allowed");
        words.push_back(*value);
    }
    return words;
}

std::vector<std::string> TomlTable::options(const std::string& key,
                                            std::span<const std::string_view> own,
                                            const std::string& whose) const {
    std::vector<std::string> options = words(key);
    for (const std::string& option : options) {
        const std::string name = option.substr(0, option.find('='));
        if (std::ranges::find(own, name) == own.end()) continue;
        refuse(
            *find(key), key,
            whose + " itself sets " + name + " of each broker, as it does all of " + listed(own));
    }
    return options;
}

std::string TomlTable::word(const std::string& key, const std::string& fallback) const {
    const toml::node* node = find(key);
    if (node == nullptr) return fallback;
    const auto value = node->value_exact<std::string>();
    if (!value || value->empty()) refuse(*node, key, "a text is allowed");
    return *value;
}

std::string TomlTable::where(const toml::source_region& source) const {
    return file_ + ", line " + std::to_string(source.begin.line) + ": ";
}

}  // namespace romano::experiments
