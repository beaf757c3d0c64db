#include "broker/rights/rules.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "broker/rights/pattern.h"
#include "romano/protection/sha256.h"

namespace romano::rights {
namespace {

constexpr std::array<std::string_view, 6> access_names = {"read", "write",    "readwrite",
                                                          "deny", "announce", "loop"};
constexpr std::array built_in_groups = {robots, operators, plain, uplink};
constexpr std::string_view blanks = " \t\r";

std::string_view trimmed(std::string_view text) {
    const std::size_t begin = text.find_first_not_of(blanks);
    if (begin == std::string_view::npos) return {};
    return text.substr(begin, text.find_last_not_of(blanks) - begin + 1);
}

/// Cuts the first word off.
std::string_view take_word(std::string_view& text) {
    const std::size_t end = std::min(text.find_first_of(blanks), text.size());
    const std::string_view word = text.substr(0, end);
    text = trimmed(text.substr(end));
    return word;
}

/// As `romano keys` has it.
bool is_name(std::string_view text) {
    constexpr std::size_t longest = 20;
    return !text.empty() && text.size() <= longest && std::ranges::all_of(text, [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
               c == '-' || c == '_';
    });
}

/// For a message to people: what is no letter of ASCII is none here.
std::string quoted(std::string_view text) {
    constexpr std::size_t most = 60;
    std::string out = "'";
    for (const char c : text.substr(0, most)) out += c >= ' ' && c <= '~' ? c : '?';
    return out + (text.size() > most ? "...'" : "'");
}

class Parser {
public:
    Result<Rules, Fault> parse(std::string_view text) {
        if (text.size() > most_octets) {
            return Fault{1, "the file is larger than a mebioctet; a rule can name a group"};
        }
        while (!text.empty()) {
            const std::size_t end = std::min(text.find('\n'), text.size());
            ++line_;
            take_line(trimmed(text.substr(0, end)));
            if (fault_) return *fault_;
            text.remove_prefix(std::min(end + 1, text.size()));
        }
        return std::move(rules_);
    }

private:
    void take_line(std::string_view line) {
        if (line.empty() || line[0] == '#') return;
        const std::string_view word = take_word(line);
        if (word == "user") {
            begin_user(line);
        } else if (word == "group") {
            begin_group(line);
        } else if (word == "member") {
            add_members(line);
        } else if (word == "topic") {
            add_rule(line, false);
        } else if (word == "pattern") {
            add_rule(line, true);
        } else {
            refuse(quoted(word) +
                   " begins no line of a rights file: user, group, member, topic and pattern do");
        }
    }

    void begin_user(std::string_view name) {
        if (!is_name(name)) return refuse_name(name);
        section_ = &rules_.users[std::string{name}];
        members_ = nullptr;
    }

    void begin_group(std::string_view name) {
        if (!is_name(name)) return refuse_name(name);
        section_ = &rules_.groups[std::string{name}];
        const bool is_built_in = std::ranges::count(built_in_groups, name) != 0;
        members_ = is_built_in ? nullptr : &rules_.members[std::string{name}];
    }

    void add_members(std::string_view names) {
        if (members_ == nullptr) {
            return refuse(
                "member stands under a group of your own; nobody is put into the groups robots, "
                "operators, plain and uplink");
        }
        if (names.empty()) return refuse("member needs the names of keys");
        while (!names.empty()) {
            const std::string_view name = take_word(names);
            if (!is_name(name)) return refuse_name(name);
            members_->emplace(name);
        }
    }

    void add_rule(std::string_view rest, bool has_id) {
        std::string_view after = rest;
        const auto named = std::ranges::find(access_names, take_word(after));
        Access access = Access::readwrite;
        if (named != access_names.end()) {
            access = static_cast<Access>(named - access_names.begin());
            rest = after;
        }
        if (rest.empty()) return refuse("a topic is missing");
        if (!is_valid_pattern(rest)) {
            return refuse(quoted(rest) +
                          " is no topic filter: '+' and %i fill a level, '#' the last one; before "
                          "it may stand read, write, readwrite, deny, announce or loop");
        }
        const bool uses_id = rest.find(own_id) != std::string_view::npos;
        if (uses_id && !has_id) {
            return refuse("%i stands in a line that begins with pattern, not with topic");
        }
        const bool is_read = access == Access::read || access == Access::deny;
        if (rest.starts_with('$') && !is_read && rest != rights_topic) {
            return refuse(quoted(rest) +
                          ": topics that begin with '$' are published by brokers alone; write "
                          "read or deny before it");
        }
        // As at mosquitto: topics before the first user are for those who have no name.
        RuleList& section = section_ != nullptr ? *section_
                            : has_id            ? rules_.everybody
                                                : rules_.groups[std::string{plain}];
        section.push_back({access, std::string{rest}});
    }

    void refuse(std::string what) { fault_ = Fault{line_, std::move(what)}; }
    void refuse_name(std::string_view name) {
        refuse("the name " + quoted(name) + " must be 1 to 20 letters, digits, '-' and '_'");
    }

    Rules rules_;
    RuleList* section_ = nullptr;
    std::set<std::string>* members_ = nullptr;
    unsigned line_ = 0;
    std::optional<Fault> fault_;
};

void add(protection::Sha256& hash, std::string_view kind, std::string_view text) {
    const auto add_text = [&hash](std::string_view part) { hash.add(as_octets(part)); };
    add_text(kind);
    add_text(text);
    add_text("\n");
}

void add(protection::Sha256& hash, const RuleList& rules) {
    for (const Rule& rule : rules) {
        add(hash, access_names[static_cast<std::size_t>(rule.access)], ' ' + rule.pattern);
    }
}

}  // namespace

Result<Rules, Fault> parse(std::string_view text) {
    return Parser{}.parse(text);
}

std::string_view usual_rules() {
    return R"(# Who may publish and read what. What no rule allows is refused; deny goes before all else.
# `romano rights check FILE` looks at a file; brokers read theirs anew at SIGHUP.

# Whoever has no key, at plain addresses: take these lines out when there are such clients that
# shall not do everything.
group plain
topic readwrite #
topic read $SYS/#
topic read $ROMANO/#

# What may come over the uplink or from ROS 2, and go there, within the rules of those.
group uplink
topic readwrite #

# A robot is moved by what comes on the topic of its id, and on common. Of its own are robots/ID/...
# and whatever else has its id as second level. It announces itself to the brokers: connection
# requests, heartbeats, in its own name alone.
group robots
pattern readwrite %i
pattern readwrite +/%i/#
topic announce init-info
topic announce common
topic read common

# The last line lets them change these rules, at all brokers: romano rights set FILE.
group operators
topic readwrite #
topic read $SYS/#
topic read $ROMANO/#
topic write $ROMANO/rights

# For a loop in which robot c1 controls robot p1, take the marks off:
#user c1
#topic loop p1
#user p1
#topic loop c1
)";
}

std::string digest_of(const Rules& rules) {
    constexpr std::size_t octets_shown = 8;
    constexpr std::string_view digits = "0123456789abcdef";
    protection::Sha256 hash;
    add(hash, "everybody", "");
    add(hash, rules.everybody);
    for (const auto& [name, list] : rules.groups) {
        add(hash, "group ", name);
        add(hash, list);
    }
    for (const auto& [name, list] : rules.users) {
        add(hash, "user ", name);
        add(hash, list);
    }
    for (const auto& [group, names] : rules.members) {
        add(hash, "members ", group);
        for (const std::string& name : names) add(hash, "member ", name);
    }
    const auto octets = hash.finish();
    std::string text;
    for (std::size_t i = 0; i < octets_shown; ++i) {
        text += digits[octets[i] >> 4U];
        text += digits[octets[i] & 0xFU];
    }
    return text;
}

}  // namespace romano::rights
