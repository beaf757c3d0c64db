#include "broker/rights/rights.h"

#include <algorithm>
#include <utility>
#include <variant>

#include "broker/protection/protected_node.h"
#include "broker/rights/pattern.h"
#include "romano/control/messages.h"
#include "romano/message/codec.h"

namespace romano::rights {

using broker::Extent;
using broker::Speaker;

namespace {

bool allows_read(Access access) {
    return access == Access::read || access == Access::readwrite;
}
bool allows_write(Access access) {
    return access == Access::write || access == Access::readwrite;
}

/// Any of the lists' rules.
template <typename Lists, typename Predicate>
bool any_rule(const Lists& lists, Predicate&& holds) {
    return std::ranges::any_of(
        lists, [&](const RuleList* list) { return std::ranges::any_of(*list, holds); });
}

template <typename Identity>
bool is_denied(const Identity& who, std::string_view topic) {
    return any_rule(who.lists, [&](const Rule& rule) {
        return rule.access == Access::deny && matches(rule.pattern, who.id, topic);
    });
}

/// What a robot tells the brokers of itself, with its own id in it.
bool is_announcement_of(std::string_view id, Bytes payload) {
    const auto message = message::decode(payload);
    if (!message) return false;
    const auto is_own = [id](const message::RomanoId& named) { return named.text() == id; };
    if (const auto* beat = std::get_if<message::Heartbeat>(&*message)) return is_own(beat->sender);
    if (const auto* request = std::get_if<message::ConnectionRequest>(&*message)) {
        return is_own(request->sender);
    }
    const auto* wish = std::get_if<message::RequestConnectedNodes>(&*message);
    return wish != nullptr && is_own(wish->asker);
}

bool is_of_a_loop(Bytes payload) {
    return !message::flaw_of(payload) && payload[0] == control::data_type;
}

/// Of a person's programs, `anna/3`, the name of the key.
std::string_view key_name_of(std::string_view client_id) {
    return client_id.substr(0, client_id.find('/'));
}

}  // namespace

Rights::Rights(Rules rules, std::span<const KeyOwner> owners) : rules_(std::move(rules)) {
    const auto add = [](Lists& lists, const RuleList* list) {
        if (list != nullptr && !list->empty()) lists.push_back(list);
    };
    for (const KeyOwner& owner : owners) {
        Member& member = members_[owner.name];
        member.role = owner.role;
        add(member.lists, &rules_.everybody);
        add(member.lists, group(owner.role == Role::robot ? robots : operators));
        for (const auto& [name, names] : rules_.members) {
            if (names.contains(owner.name)) add(member.lists, group(name));
        }
        const auto own = rules_.users.find(owner.name);
        if (own != rules_.users.end()) add(member.lists, &own->second);
    }
    add(plain_, group(plain));
    add(uplink_, group(uplink));
}

const RuleList* Rights::group(std::string_view name) const {
    const auto found = rules_.groups.find(name);
    return found == rules_.groups.end() ? nullptr : &found->second;
}

const Rights::Member* Rights::owner_of(std::string_view client_id) const {
    const auto found = members_.find(key_name_of(client_id));
    return found == members_.end() ? nullptr : &found->second;
}

Rights::Identity Rights::identity_of(const Speaker& who) const {
    if (who.is_owner) return {uplink_, {}};
    if (!broker::is_authenticated(who.via)) return {plain_, who.client_id};
    const std::string_view id = broker::authenticated_id(who.via, who.node_id);
    const Member* owner = owner_of(id);
    if (owner == nullptr) return {nobody_, {}};  // its key was withdrawn
    return {owner->lists, key_name_of(id)};
}

bool Rights::is_operator(const Speaker& who) const {
    if (who.is_owner || !broker::is_authenticated(who.via)) return false;
    const Member* owner = owner_of(broker::authenticated_id(who.via, who.node_id));
    return owner != nullptr && owner->role == Role::person;
}

std::vector<KeyOwner> Rights::owners() const {
    std::vector<KeyOwner> all;
    for (const auto& [name, member] : members_) all.push_back({name, member.role});
    return all;
}

bool Rights::may_set_rights(const Speaker& who, Bytes text) const {
    if (!may_publish_something(who, rights_topic)) return false;
    if (text.empty()) return true;
    auto rules = parse(as_text(text));
    if (!rules) return false;
    const Rights next{std::move(*rules), owners()};
    return next.may_publish_something(who, rights_topic);
}

bool Rights::may_publish(const Speaker& who, std::string_view topic, Bytes payload) const {
    if (topic == rights_topic) return may_set_rights(who, payload);
    const Identity identity = identity_of(who);
    if (is_denied(identity, topic)) return false;
    return any_rule(identity.lists, [&](const Rule& rule) {
        if (rule.access == Access::read || rule.access == Access::deny ||
            !matches(rule.pattern, identity.id, topic)) {
            return false;
        }
        return allows_write(rule.access) ||
               (rule.access == Access::announce && is_announcement_of(identity.id, payload)) ||
               (rule.access == Access::loop && is_of_a_loop(payload));
    });
}

bool Rights::may_publish_something(const Speaker& who, std::string_view topic) const {
    if (topic == rights_topic && !is_operator(who)) return false;
    const Identity identity = identity_of(who);
    return !is_denied(identity, topic) && any_rule(identity.lists, [&](const Rule& rule) {
        return rule.access != Access::read && rule.access != Access::deny &&
               matches(rule.pattern, identity.id, topic);
    });
}

bool Rights::may_read(const Speaker& who, std::string_view topic) const {
    const Identity identity = identity_of(who);
    return !is_denied(identity, topic) && any_rule(identity.lists, [&](const Rule& rule) {
        return allows_read(rule.access) && matches(rule.pattern, identity.id, topic);
    });
}

Extent Rights::may_read_of(const Speaker& who, std::string_view filter) const {
    const Identity identity = identity_of(who);
    const auto denies = [&](auto&& how) {
        return any_rule(identity.lists, [&](const Rule& rule) {
            return rule.access == Access::deny && how(rule.pattern, identity.id, filter);
        });
    };
    const auto allows = [&](auto&& how) {
        return any_rule(identity.lists, [&](const Rule& rule) {
            return allows_read(rule.access) && how(rule.pattern, identity.id, filter);
        });
    };
    if (denies(covers) || !allows(overlaps)) return Extent::none;
    return allows(covers) && !denies(overlaps) ? Extent::all : Extent::some;
}

std::string Rights::name_of(const Speaker& who) const {
    if (who.is_owner) return "the uplink";
    if (!broker::is_authenticated(who.via)) {
        return who.client_id.empty() ? "a plain client without a session"
                                     : "plain client '" + std::string{who.client_id} + "'";
    }
    const std::string_view id = broker::authenticated_id(who.via, who.node_id);
    const Member* owner = owner_of(id);
    const char* kind = owner == nullptr             ? "withdrawn client "
                       : owner->role == Role::robot ? "robot "
                                                    : "operator ";
    return kind + std::string{id};
}

}  // namespace romano::rights
