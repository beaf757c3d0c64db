#include "broker/uplink/topic_rules.h"

#include <algorithm>
#include <array>

#include "romano/mqttsn/topic.h"

namespace romano::uplink {

using mqttsn::Qos;

namespace {

std::vector<std::string> words_of(std::string_view text) {
    std::vector<std::string> words;
    for (;;) {
        const auto begin = text.find_first_not_of(" \t");
        if (begin == std::string_view::npos) return words;
        text.remove_prefix(begin);
        const auto end = std::min(text.find_first_of(" \t"), text.size());
        words.emplace_back(text.substr(0, end));
        text.remove_prefix(end);
    }
}

/// Empty when the topic is not this rule's.
std::optional<Place> translated(std::string_view topic, Qos qos, const TopicRule& rule,
                                const std::string& from, const std::string& to) {
    if (!topic.starts_with(from)) return std::nullopt;
    const std::string_view rest = topic.substr(from.size());
    if (!mqttsn::matches(rule.pattern, rest)) return std::nullopt;
    std::string name = to + std::string{rest};
    if (name.starts_with('$') || !mqttsn::is_valid_topic_name(name)) return std::nullopt;
    return Place{std::move(name), std::min(qos, rule.most)};
}

bool is_prefix(const std::string& text) {
    return text.empty() || (mqttsn::is_valid_topic_name(text) && !text.starts_with('$'));
}

void add(std::vector<Filter>& filters, Filter filter) {
    const auto same = std::ranges::find(filters, filter.filter, &Filter::filter);
    if (same == filters.end()) {
        filters.push_back(std::move(filter));
    } else {
        same->qos = std::max(same->qos, filter.qos);
    }
}

}  // namespace

Result<TopicRule, std::string> parse_rule(std::string_view text) {
    const auto words = words_of(text);
    if (words.empty() || words.size() > 5) {
        return std::string{"write PATTERN [out|in|both] [QOS] [LOCAL-PREFIX] [REMOTE-PREFIX]"};
    }
    TopicRule rule{.pattern = words[0], .local_prefix = {}, .remote_prefix = {}};
    if (!mqttsn::is_valid_topic_filter(rule.pattern) || rule.pattern.starts_with('$')) {
        return std::string{"the pattern must be a topic filter, and not begin with $"};
    }
    if (words.size() > 1) {
        static constexpr std::array<std::string_view, 3> ways = {"out", "in", "both"};
        if (std::ranges::count(ways, words[1]) == 0) {
            return std::string{"the direction must be out, in or both"};
        }
        rule.out = words[1] != "in";
        rule.in = words[1] != "out";
    }
    if (words.size() > 2) {
        if (words[2] != "0" && words[2] != "1" && words[2] != "2") {
            return std::string{"the QoS must be 0, 1 or 2"};
        }
        rule.most = static_cast<Qos>(words[2][0] - '0');
    }
    if (words.size() > 3 && words[3] != "\"\"") rule.local_prefix = words[3];
    if (words.size() > 4 && words[4] != "\"\"") rule.remote_prefix = words[4];
    if (!is_prefix(rule.local_prefix) || !is_prefix(rule.remote_prefix)) {
        return std::string{"a prefix must be the beginning of a topic name, without wildcards"};
    }
    if (!mqttsn::is_valid_topic_filter(rule.local_prefix + rule.pattern) ||
        !mqttsn::is_valid_topic_filter(rule.remote_prefix + rule.pattern)) {
        return std::string{"a prefix before a pattern that begins with a wildcard must end with /"};
    }
    return rule;
}

std::vector<Filter> TopicRules::local_filters() const {
    std::vector<Filter> filters;
    for (const TopicRule& rule : rules_) {
        if (rule.out) add(filters, {rule.local_prefix + rule.pattern, rule.most});
    }
    return filters;
}

std::vector<Filter> TopicRules::remote_filters() const {
    std::vector<Filter> filters;
    for (const TopicRule& rule : rules_) {
        if (rule.in) add(filters, {rule.remote_prefix + rule.pattern, rule.most});
    }
    return filters;
}

std::optional<Place> TopicRules::to_remote(std::string_view topic, Qos qos) const {
    if (topic.starts_with('$')) return std::nullopt;
    for (const TopicRule& rule : rules_) {
        if (!rule.out) continue;
        auto place = translated(topic, qos, rule, rule.local_prefix, rule.remote_prefix);
        if (place) return place;
    }
    return std::nullopt;
}

std::optional<Place> TopicRules::to_local(std::string_view topic, Qos qos) const {
    if (topic.starts_with('$')) return std::nullopt;
    for (const TopicRule& rule : rules_) {
        if (!rule.in) continue;
        auto place = translated(topic, qos, rule, rule.remote_prefix, rule.local_prefix);
        if (place) return place;
    }
    return std::nullopt;
}

}  // namespace romano::uplink
