#include "overlay/ros2/rules.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "romano/mqttsn/topic.h"

namespace romano::ros2 {
namespace {

using Error = std::string;
constexpr std::string_view wildcards = "+#";

std::vector<std::string_view> words_of(std::string_view text) {
    std::vector<std::string_view> words;
    for (;;) {
        const auto begin = text.find_first_not_of(" \t\r");
        if (begin == std::string_view::npos) return words;
        text.remove_prefix(begin);
        const auto end = std::min(text.find_first_of(" \t\r"), text.size());
        words.push_back(text.substr(0, end));
        text.remove_prefix(end);
    }
}

std::string quoted(std::string_view text) {
    return '\'' + std::string{text} + '\'';
}

// --- keys

std::optional<double> number_in(std::string_view text, double least, double most) {
    double value = 0;
    const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
    if (read.ec != std::errc{} || read.ptr != text.data() + text.size()) return std::nullopt;
    if (!(value >= least && value <= most)) return std::nullopt;
    return value;
}

enum class Takers : std::uint8_t { all, stamped, twist, odometry, battery_state, range };

bool takes(Takers takers, RosType type) {
    switch (takers) {
        case Takers::all:
            return true;
        case Takers::stamped:
            return type == RosType::odometry || type == RosType::battery_state ||
                   type == RosType::range;
        case Takers::twist:
            return type == RosType::twist;
        case Takers::odometry:
            return type == RosType::odometry;
        case Takers::battery_state:
            return type == RosType::battery_state;
        case Takers::range:
            break;
    }
    return type == RosType::range;
}

struct Key {
    std::string_view name;
    Takers takers;
    std::string_view allowed;
    bool (*set)(Rule& rule, std::string_view value);
};

bool set_number(double& field, std::string_view value, double least, double most) {
    const auto number = number_in(value, least, most);
    if (number) field = *number;
    return number.has_value();
}

bool set_frame(std::string& field, std::string_view value) {
    field = value;
    return !value.empty();
}

constexpr std::array<Key, 14> keys{{
    {"qos", Takers::all, "0, 1 or 2",
     [](Rule& rule, std::string_view value) {
         if (value != "0" && value != "1" && value != "2") return false;
         rule.qos = static_cast<mqttsn::Qos>(value[0] - '0');
         return true;
     }},
    {"retained", Takers::all, "yes or no",
     [](Rule& rule, std::string_view value) {
         rule.retained = value == "yes";
         return value == "yes" || value == "no";
     }},
    {"node", Takers::all, "a ROS 2 name: letters, digits and underscores",
     [](Rule& rule, std::string_view value) {
         rule.node = value;
         return is_ros_name(filled(value, "x"));
     }},
    {"frame", Takers::stamped, "a frame's name",
     [](Rule& rule, std::string_view value) { return set_frame(rule.frame, value); }},
    {"child", Takers::odometry, "a frame's name",
     [](Rule& rule, std::string_view value) { return set_frame(rule.child_frame, value); }},
    {"speed", Takers::twist, "0.001 to 100 m/s",
     [](Rule& rule, std::string_view value) { return set_number(rule.speed, value, 0.001, 100); }},
    {"turn", Takers::twist, "0.001 to 100 rad/s",
     [](Rule& rule, std::string_view value) { return set_number(rule.turn, value, 0.001, 100); }},
    {"step-ms", Takers::twist, "1 to 60000 ms",
     [](Rule& rule, std::string_view value) {
         const auto number = number_in(value, 1, 60'000);
         if (number) rule.step = std::chrono::milliseconds{std::lround(*number)};
         return number.has_value();
     }},
    {"full", Takers::battery_state, "0.1 to 1000 V",
     [](Rule& rule, std::string_view value) { return set_number(rule.full, value, 0.1, 1000); }},
    {"empty", Takers::battery_state, "0.1 to 1000 V",
     [](Rule& rule, std::string_view value) { return set_number(rule.empty, value, 0.1, 1000); }},
    {"radiation", Takers::range, "ultrasound or infrared",
     [](Rule& rule, std::string_view value) {
         rule.radiation_type = value == "infrared" ? 1 : 0;
         return value == "ultrasound" || value == "infrared";
     }},
    {"fov", Takers::range, "0 to 6.3 rad",
     [](Rule& rule, std::string_view value) {
         return set_number(rule.field_of_view, value, 0, 6.3);
     }},
    {"min", Takers::range, "0 to 1000 m",
     [](Rule& rule, std::string_view value) { return set_number(rule.min_range, value, 0, 1000); }},
    {"max", Takers::range, "0 to 1000 m",
     [](Rule& rule, std::string_view value) { return set_number(rule.max_range, value, 0, 1000); }},
}};

std::string keys_for(RosType type) {
    std::string out;
    for (const Key& key : keys) {
        if (!takes(key.takers, type)) continue;
        out += (out.empty() ? "" : ", ") + std::string{key.name};
    }
    return out;
}

/// Empty when it was read.
Error read_key(Rule& rule, std::string_view word) {
    const auto equals = word.find('=');
    const auto name = word.substr(0, equals);
    const auto key = std::ranges::find(keys, name, &Key::name);
    if (name.empty() || equals == std::string_view::npos || key == keys.end() ||
        !takes(key->takers, rule.type)) {
        return quoted(word) + " is no setting of " + std::string{name_of(rule.type)} +
               "; write KEY=VALUE with one of " + keys_for(rule.type);
    }
    const auto value = word.substr(equals + 1);
    if (key->set(rule, value)) return {};
    return std::string{name} + ' ' + quoted(value) + " must be " + std::string{key->allowed};
}

// --- topics

char wildcard_of(std::string_view pattern) {
    const auto at = pattern.find_first_of(wildcards);
    return at == std::string_view::npos ? '\0' : pattern[at];
}

Error check_topics(const Rule& rule) {
    if (!mqttsn::is_valid_topic_filter(rule.romano) || rule.romano.starts_with('$')) {
        return quoted(rule.romano) +
               " is no ROMANO topic; a wildcard is a whole level, $ is no beginning";
    }
    const bool is_name = is_ros_topic(filled(rule.ros, "x"));
    if (!is_name || (wildcard_of(rule.ros) == '#' && !rule.ros.ends_with("/#"))) {
        return quoted(rule.ros) +
               " is no ROS 2 topic; write /NAME/NAME, names of letters, digits and underscores "
               "that begin with no digit";
    }
    if (std::ranges::count_if(rule.romano, [](char c) { return c == '+' || c == '#'; }) > 1 ||
        wildcard_of(rule.romano) != wildcard_of(rule.ros)) {
        return quoted(rule.romano) + " and " + quoted(rule.ros) +
               " must have the same wildcard, + or #, once each, or none";
    }
    for (const std::string* text : {&rule.node, &rule.frame, &rule.child_frame}) {
        if (has_wildcard(*text) && wildcard_of(rule.ros) != '+') {
            return quoted(*text) + " has a wildcard, but the topics have no +";
        }
    }
    return {};
}

/// Of two rules that can fit one ROS 2 topic.
bool may_meet(std::string_view a, std::string_view b) {
    return a == b || wild_part(a, filled(b, "x")) || wild_part(b, filled(a, "x"));
}

Error check_types(const std::vector<Rule>& earlier, const Rule& rule) {
    for (const Rule& other : earlier) {
        if (other.type == rule.type || !may_meet(other.ros, rule.ros)) continue;
        return quoted(rule.ros) + " is " + std::string{name_of(rule.type)} +
               " here and fits what is " + std::string{name_of(other.type)} + " in line " +
               std::to_string(other.line) + "; a ROS 2 topic has one type";
    }
    return {};
}

Error check_values(const Rule& rule) {
    if ((rule.full != 0 || rule.empty != 0) && !(rule.full > rule.empty && rule.empty > 0)) {
        return "full and empty must be given together, full higher than empty";
    }
    if (rule.max_range <= rule.min_range) return "max must be more than min";
    return {};
}

Result<Rule, Error> parse_rule(std::string_view text, std::size_t line) {
    const auto words = words_of(text);
    static constexpr std::array<std::string_view, 3> ways = {"out", "in", "both"};
    if (words.size() < 4) {
        return Error{"write DIRECTION ROMANO-TOPIC ROS-TOPIC TYPE [KEY=VALUE ...]"};
    }
    if (std::ranges::count(ways, words[0]) == 0) {
        return quoted(words[0]) + " is no direction; write out (to ROS 2), in or both";
    }
    const auto type = type_named(words[3]);
    if (!type) {
        return quoted(words[3]) + " is no type that is bridged; write " + names_of_types();
    }
    Rule rule{.line = line,
              .out = words[0] != "in",
              .in = words[0] != "out",
              .romano = std::string{words[1]},
              .ros = std::string{words[2]},
              .type = *type};
    for (std::size_t i = 4; i < words.size(); ++i) {
        if (Error wrong = read_key(rule, words[i]); !wrong.empty()) return wrong;
    }
    if (rule.node.empty()) rule.node = wildcard_of(rule.ros) == '+' ? "robot_+" : bridge_node;
    if (Error wrong = check_topics(rule); !wrong.empty()) return wrong;
    if (Error wrong = check_values(rule); !wrong.empty()) return wrong;
    return rule;
}

}  // namespace

bool has_wildcard(std::string_view pattern) {
    return wildcard_of(pattern) != '\0';
}

std::optional<std::string> wild_part(std::string_view pattern, std::string_view topic) {
    const auto at = pattern.find_first_of(wildcards);
    if (at == std::string_view::npos) {
        return pattern == topic ? std::optional<std::string>{std::string{}} : std::nullopt;
    }
    const auto before = pattern.substr(0, at);
    const auto after = pattern.substr(at + 1);
    if (topic.size() <= before.size() + after.size()) return std::nullopt;
    if (!topic.starts_with(before) || !topic.ends_with(after)) return std::nullopt;
    const auto part = topic.substr(before.size(), topic.size() - before.size() - after.size());
    if (pattern[at] == '+' && part.find('/') != std::string_view::npos) return std::nullopt;
    return std::string{part};
}

std::string filled(std::string_view pattern, std::string_view part) {
    const auto at = pattern.find_first_of(wildcards);
    if (at == std::string_view::npos) return std::string{pattern};
    return std::string{pattern.substr(0, at)} + std::string{part} +
           std::string{pattern.substr(at + 1)};
}

Result<std::vector<Rule>, std::string> parse_rules(std::string_view text) {
    std::vector<Rule> rules;
    for (std::size_t line = 1; !text.empty(); ++line) {
        const auto end = std::min(text.find('\n'), text.size());
        const auto words = words_of(text.substr(0, end));
        if (!words.empty() && !words[0].starts_with('#')) {
            auto rule = parse_rule(text.substr(0, end), line);
            Error wrong = rule ? check_types(rules, rule.value()) : rule.error();
            if (!wrong.empty()) return "line " + std::to_string(line) + ": " + wrong;
            rules.push_back(std::move(rule.value()));
        }
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    if (rules.empty()) return std::string{"there is no rule in it"};
    return rules;
}

}  // namespace romano::ros2
