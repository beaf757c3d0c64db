#include "broker/rights/pattern.h"

#include <cstddef>

#include "romano/mqttsn/topic.h"

namespace romano::rights {
namespace {

/// The levels of a filter or a topic, one after the other.
class Levels {
public:
    explicit Levels(std::string_view text) : rest_(text) {}

    [[nodiscard]] bool at_end() const { return at_end_; }
    std::string_view take() {
        const std::size_t slash = rest_.find('/');
        const std::string_view level = rest_.substr(0, slash);
        at_end_ = slash == std::string_view::npos;
        rest_ = at_end_ ? std::string_view{} : rest_.substr(slash + 1);
        return level;
    }
    /// "a/#" has the topic "a", too.
    [[nodiscard]] bool has_nothing_but_open_end() const { return !at_end_ && rest_ == "#"; }

private:
    std::string_view rest_;
    bool at_end_ = false;
};

bool is_hidden(std::string_view level) {
    return level.starts_with('$');
}

bool is_wildcard(std::string_view level) {
    return level == "+" || level == "#";
}

/// The topic level, or a filter's level that is no wildcard, is one of the pattern's.
bool takes(std::string_view pattern, std::string_view id, std::string_view level, bool is_first) {
    if (pattern == "+") return !(is_first && is_hidden(level));
    if (pattern == own_id) return !id.empty() && !is_hidden(id) && level == id;
    return pattern == level;
}

}  // namespace

bool is_valid_pattern(std::string_view pattern) {
    if (!mqttsn::is_valid_topic_filter(pattern)) return false;
    for (Levels levels(pattern); !levels.at_end();) {
        const std::string_view level = levels.take();
        if (level.find(own_id) != std::string_view::npos && level != own_id) return false;
    }
    return true;
}

bool matches(std::string_view pattern, std::string_view id, std::string_view topic) {
    Levels ours(pattern);
    Levels names(topic);
    for (bool is_first = true;; is_first = false) {
        const std::string_view our = ours.take();
        const std::string_view name = names.take();
        if (our == "#") return !(is_first && is_hidden(name));
        if (!takes(our, id, name, is_first)) return false;
        if (names.at_end()) return ours.at_end() || ours.has_nothing_but_open_end();
        if (ours.at_end()) return false;
    }
}

bool covers(std::string_view pattern, std::string_view id, std::string_view filter) {
    Levels ours(pattern);
    Levels theirs(filter);
    for (bool is_first = true;; is_first = false) {
        const std::string_view our = ours.take();
        const std::string_view their = theirs.take();
        if (our == "#") return !(is_first && is_hidden(their));
        if (is_wildcard(their)) {
            if (our != "+") return false;
            if (their == "#") return is_first && ours.has_nothing_but_open_end();  // "+/#"
        } else if (!takes(our, id, their, is_first)) {
            return false;
        }
        if (theirs.at_end()) return ours.at_end() || ours.has_nothing_but_open_end();
        if (ours.at_end()) return false;
    }
}

bool overlaps(std::string_view pattern, std::string_view id, std::string_view filter) {
    Levels ours(pattern);
    Levels theirs(filter);
    for (bool is_first = true;; is_first = false) {
        const std::string_view our = ours.take();
        const std::string_view their = theirs.take();
        if (our == "#") return !(is_first && is_hidden(their));
        if (is_wildcard(their)) {
            if (is_first && is_hidden(our)) return false;
            if (our == own_id && !takes(our, id, id, is_first)) return false;
            if (their == "#") return true;
        } else if (!takes(our, id, their, is_first)) {
            return false;
        }
        if (ours.at_end()) return theirs.at_end() || theirs.has_nothing_but_open_end();
        if (theirs.at_end()) return ours.has_nothing_but_open_end();
    }
}

}  // namespace romano::rights
