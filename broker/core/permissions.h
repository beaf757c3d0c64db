// Who may publish and read what, as the procedures ask it. Nobody is asked where BrokerCore was
// given none: then everybody may do everything.
//
// The rules are not the core's matter (broker/rights); to be told no is: enforcement.h.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "romano/base/bytes.h"
#include "romano/base/endpoint.h"

namespace romano::broker {

/// Whose right is asked for. Views live as long as the question.
struct Speaker {
    Endpoint via;                // the service address that it talks to
    std::string_view node_id;    // ClientAddress::wireless_node_id
    std::string_view client_id;  // empty without a session
    bool is_owner = false;       // BrokerOptions::read_by_owner: nobody on the network
};

/// How much of something.
enum class Extent : std::uint8_t { none, some, all };

class Permissions {
public:
    virtual ~Permissions() = default;
    [[nodiscard]] virtual bool may_publish(const Speaker& who, std::string_view topic,
                                           Bytes payload) const = 0;
    /// Any message at all, for who has not said yet what: a topic id is asked for, or a will made.
    [[nodiscard]] virtual bool may_publish_something(const Speaker& who,
                                                     std::string_view topic) const = 0;
    [[nodiscard]] virtual bool may_read(const Speaker& who, std::string_view topic) const = 0;
    /// Of the topics of a filter. `all` spares further questions about them.
    [[nodiscard]] virtual Extent may_read_of(const Speaker& who, std::string_view filter) const = 0;
    /// For people: "robot abcd1234".
    [[nodiscard]] virtual std::string name_of(const Speaker& who) const = 0;
};

}  // namespace romano::broker
