// What the procedures do when a client may not (permissions.h): each refusal is counted, and told
// to people in a line, one a second at most, which says how many there were since the last one.
#pragma once

#include <cstdint>
#include <string_view>

#include "broker/core/session.h"
#include "broker/core/tables.h"
#include "romano/base/bytes.h"

namespace romano::broker {

[[nodiscard]] inline Speaker speaker_of(const Session& session) {
    const SessionHeader& header = session.header;
    return {header.via, header.address.wireless_node_id, header.client_id, session.read_by_owner};
}

class Enforcement {
public:
    explicit Enforcement(Tables& tables) : tables_(tables) {}

    [[nodiscard]] bool may_publish(const Speaker& who, std::string_view topic, Bytes payload,
                                   Turn& turn) {
        const Permissions* permissions = tables_.permissions;
        if (permissions == nullptr || permissions->may_publish(who, topic, payload)) return true;
        refuse(Refused::publish, who, topic, turn);
        return false;
    }
    /// A topic id to publish under.
    [[nodiscard]] bool may_register(const Speaker& who, std::string_view topic, Turn& turn) {
        return may_publish_something(Refused::register_, who, topic, turn);
    }
    [[nodiscard]] bool may_make_will(const Speaker& who, std::string_view topic, Turn& turn) {
        return may_publish_something(Refused::will, who, topic, turn);
    }
    [[nodiscard]] bool may_say_will(const Speaker& who, const Will& will, Turn& turn) {
        const Permissions* permissions = tables_.permissions;
        if (permissions == nullptr || permissions->may_publish(who, will.topic, will.message)) {
            return true;
        }
        refuse(Refused::will, who, will.topic, turn);
        return false;
    }
    /// Of a filter's topics some at least; the others are not delivered (may_deliver()).
    [[nodiscard]] bool may_subscribe(const Speaker& who, std::string_view filter, Turn& turn) {
        const Permissions* permissions = tables_.permissions;
        if (permissions == nullptr || permissions->may_read_of(who, filter) != Extent::none) {
            return true;
        }
        refuse(Refused::subscribe, who, filter, turn);
        return false;
    }
    /// Counted, and not told: who subscribes to "#" gets of it what it may read.
    [[nodiscard]] bool may_deliver(const Session& session, std::string_view topic) {
        const Permissions* permissions = tables_.permissions;
        if (permissions == nullptr || permissions->may_read(speaker_of(session), topic)) {
            return true;
        }
        tables_.counters.count(Refused::delivery);
        return false;
    }

private:
    [[nodiscard]] bool may_publish_something(Refused what, const Speaker& who,
                                             std::string_view topic, Turn& turn) {
        const Permissions* permissions = tables_.permissions;
        if (permissions == nullptr || permissions->may_publish_something(who, topic)) return true;
        refuse(what, who, topic, turn);
        return false;
    }
    void refuse(Refused what, const Speaker& who, std::string_view topic, Turn& turn);

    Tables& tables_;
    Notes notes_;               // beside the others, so that neither hides the other
    std::uint64_t untold_ = 0;  // refusals since the last line
};

}  // namespace romano::broker
