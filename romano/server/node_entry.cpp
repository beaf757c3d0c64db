#include "romano/server/node_entry.h"

#include <array>
#include <charconv>

namespace romano::server {
namespace {

constexpr std::string_view prefix = "$ROMANO/nodes/";
constexpr std::array<std::string_view, 2> forms = {"binary", "legacy"};
constexpr std::array<std::string_view, 3> states = {"connected", "silent", "away"};

/// Takes "key=value" and the blank behind it off the front; the value is all that is left when
/// `to_the_end`.
std::optional<std::string_view> take(std::string_view& text, std::string_view key,
                                     bool to_the_end = false) {
    if (!text.starts_with(key) || !text.substr(key.size()).starts_with('=')) return std::nullopt;
    text.remove_prefix(key.size() + 1);
    const std::size_t end = to_the_end ? text.size() : text.find(' ');
    if (end == std::string_view::npos) return std::nullopt;
    const std::string_view value = text.substr(0, end);
    text.remove_prefix(to_the_end ? end : end + 1);
    return value;
}

template <typename Enum, std::size_t Size>
std::optional<Enum> named(std::optional<std::string_view> name,
                          const std::array<std::string_view, Size>& names) {
    for (std::size_t i = 0; name && i < Size; ++i) {
        if (names[i] == *name) return static_cast<Enum>(i);
    }
    return std::nullopt;
}

std::optional<std::uint64_t> number(std::optional<std::string_view> text) {
    if (!text) return std::nullopt;
    std::uint64_t value = 0;
    const char* end = text->data() + text->size();
    const auto [stop, error] = std::from_chars(text->data(), end, value);
    if (error != std::errc{} || stop != end) return std::nullopt;
    return value;
}

}  // namespace

std::string_view name_of(Form form) {
    return forms[static_cast<std::size_t>(form)];
}
std::string_view name_of(NodeState state) {
    return states[static_cast<std::size_t>(state)];
}

std::string entry_topic(const message::RomanoId& id) {
    return std::string{prefix} + std::string{id.text()};
}

std::optional<message::RomanoId> robot_of_entry(std::string_view topic) {
    if (!topic.starts_with(prefix)) return std::nullopt;
    return message::RomanoId::parse(topic.substr(prefix.size()));
}

std::string to_text(const NodeEntry& entry) {
    std::string text = "form=";
    text += name_of(entry.form);
    text += " state=";
    text += name_of(entry.state);
    text += " heartbeat_unix_ms=" + std::to_string(entry.heartbeat_unix_ms);
    text += " home=" + entry.home;
    text += " client=" + entry.client;
    return text;
}

std::optional<NodeEntry> parse_entry(std::string_view topic, std::string_view text) {
    if (!topic.starts_with(prefix)) return std::nullopt;
    const auto id = message::RomanoId::parse(topic.substr(prefix.size()));
    const auto form = named<Form>(take(text, "form"), forms);
    const auto state = named<NodeState>(take(text, "state"), states);
    const auto heartbeat = number(take(text, "heartbeat_unix_ms"));
    const auto home = take(text, "home");
    const auto client = take(text, "client", true);
    if (!id || !form || !state || !heartbeat || !home || !client) return std::nullopt;
    return NodeEntry{.id = *id,
                     .form = *form,
                     .state = *state,
                     .heartbeat_unix_ms = *heartbeat,
                     .home = std::string{*home},
                     .client = std::string{*client}};
}

}  // namespace romano::server
