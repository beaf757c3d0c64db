// Rules with the clients that have keys: who may publish and read what.
//
// Who somebody is, is decided by the key alone: at a sealed address whose it is, at a plain one
// nobody's, whatever the client id says. Immutable; the owner makes another one when rules or keys
// change. A question allocates nothing, but for whether somebody may set rights.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "broker/core/permissions.h"
#include "broker/rights/rules.h"

namespace romano::rights {

enum class Role : std::uint8_t { robot, person };

struct KeyOwner {
    std::string name;
    Role role = Role::robot;
};

class Rights final : public broker::Permissions {
public:
    Rights(Rules rules, std::span<const KeyOwner> owners);
    Rights(const Rights&) = delete;
    Rights& operator=(const Rights&) = delete;

    [[nodiscard]] bool may_publish(const broker::Speaker& who, std::string_view topic,
                                   Bytes payload) const override;
    [[nodiscard]] bool may_publish_something(const broker::Speaker& who,
                                             std::string_view topic) const override;
    [[nodiscard]] bool may_read(const broker::Speaker& who, std::string_view topic) const override;
    [[nodiscard]] broker::Extent may_read_of(const broker::Speaker& who,
                                             std::string_view filter) const override;
    [[nodiscard]] std::string name_of(const broker::Speaker& who) const override;

private:
    /// All that holds for somebody.
    using Lists = std::vector<const RuleList*>;
    struct Member {
        Role role = Role::robot;
        Lists lists;
    };
    struct Identity {
        const Lists& lists;
        std::string_view id;  // what %i stands for
    };
    struct Hash {
        using is_transparent = void;
        std::size_t operator()(std::string_view text) const {
            return std::hash<std::string_view>{}(text);
        }
    };
    using Members = std::unordered_map<std::string, Member, Hash, std::equal_to<>>;

    /// By an operator alone; and nobody takes that right from himself, so that whoever has made a
    /// mistake can mend it.
    [[nodiscard]] bool may_set_rights(const broker::Speaker& who, Bytes text) const;
    [[nodiscard]] bool is_operator(const broker::Speaker& who) const;
    [[nodiscard]] std::vector<KeyOwner> owners() const;

    [[nodiscard]] const RuleList* group(std::string_view name) const;
    [[nodiscard]] Identity identity_of(const broker::Speaker& who) const;
    [[nodiscard]] const Member* owner_of(std::string_view client_id) const;

    Rules rules_;
    Members members_;  // by the name of the key
    Lists plain_;
    Lists uplink_;
    Lists nobody_;
};

}  // namespace romano::rights
