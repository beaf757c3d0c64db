// Who else than the own clients may want a message of QoS 0. Asked before one is built for them.
#pragma once

#include <string_view>

namespace romano::broker {

class Audience {
public:
    virtual ~Audience() = default;
    [[nodiscard]] virtual bool wants(std::string_view topic) const = 0;
};

}  // namespace romano::broker
