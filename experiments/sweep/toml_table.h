// One table of a TOML file that people write. Every access names its key, so that the rest is
// unknown; what is wrong is a SettingError, one sentence that names the setting, the value and what
// is allowed.
#pragma once

#include <toml++/toml.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "experiments/sweep/setting_error.h"

namespace romano::experiments {

/// "a, b, c".
[[nodiscard]] std::string listed(std::span<const std::string_view> names);

/// Throws SettingError with file and line when it is no TOML.
[[nodiscard]] toml::table parse_toml(std::string_view text, const std::string& file_name);

class TomlTable {
public:
    using Seconds = std::chrono::duration<double>;

    /// `section` stands before the keys in sentences: "axes.".
    TomlTable(const toml::table& table, const std::string& file, std::string section)
        : table_(table), file_(file), section_(std::move(section)) {}

    [[noreturn]] void refuse(const toml::node& node, const std::string& setting,
                             const std::string& allowed) const;
    void allow_only(std::span<const std::string_view> keys) const;
    void allow_only(std::initializer_list<std::string_view> keys) const {
        allow_only(std::span{keys.begin(), keys.size()});
    }

    [[nodiscard]] const toml::node* find(std::string_view key) const { return table_.get(key); }

    /// What does not stand there is `fallback`; what is none of its kind is refused.
    [[nodiscard]] std::int64_t integer(const std::string& key, std::int64_t fallback,
                                       std::int64_t low, std::int64_t high) const;
    [[nodiscard]] std::int64_t integer_in(const toml::node& node, const std::string& key,
                                          std::int64_t low, std::int64_t high) const;
    [[nodiscard]] double number_in(const toml::node& node, const std::string& key, double low,
                                   double high, const char* allowed) const;
    [[nodiscard]] Seconds seconds(const std::string& key, Seconds fallback) const;
    [[nodiscard]] std::vector<std::string> words(
        const std::string& key, const std::vector<std::string>& fallback = {}) const;
    /// Options of a broker, but none of `own`, which `whose` ("the sweep") sets itself.
    [[nodiscard]] std::vector<std::string> options(const std::string& key,
                                                   std::span<const std::string_view> own,
                                                   const std::string& whose) const;
    [[nodiscard]] std::string word(const std::string& key, const std::string& fallback) const;

    /// Each value of an axis; a single value stands for a list of one.
    template <typename Value>
    std::vector<Value> axis(const std::string& key, Value fallback,
                            const std::function<Value(const toml::node&)>& read) const {
        const toml::node* node = find(key);
        if (node == nullptr) return {fallback};
        const toml::array* list = node->as_array();
        if (list == nullptr) return {read(*node)};
        if (list->empty()) refuse(*node, key, "at least one value is needed");
        std::vector<Value> values;
        for (const toml::node& item : *list) {
            values.push_back(read(item));
            if (std::ranges::count(values, values.back()) > 1) {
                refuse(*node, key, "a value may stand there once");
            }
        }
        return values;
    }

private:
    [[nodiscard]] std::string where(const toml::source_region& source) const;

    const toml::table& table_;
    const std::string& file_;
    std::string section_;
};

}  // namespace romano::experiments
