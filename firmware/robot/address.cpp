#include "firmware/robot/address.h"

#include <algorithm>
#include <iterator>

namespace romano::firmware {

Endpoint endpoint_of(const romano_address& address) {
    Endpoint endpoint;
    std::copy(std::begin(address.ip), std::end(address.ip), endpoint.address.begin());
    endpoint.scope = address.scope;
    endpoint.port = address.port;
    endpoint.family = address.family == 4   ? Endpoint::Family::ipv4
                      : address.family == 6 ? Endpoint::Family::ipv6
                                            : Endpoint::Family::none;
    return endpoint;
}

romano_address address_of(const Endpoint& endpoint) {
    romano_address address{};
    std::copy(endpoint.address.begin(), endpoint.address.end(), std::begin(address.ip));
    address.scope = endpoint.scope;
    address.port = endpoint.port;
    address.family = endpoint.family == Endpoint::Family::ipv4   ? 4
                     : endpoint.family == Endpoint::Family::ipv6 ? 6
                                                                 : 0;
    return address;
}

}  // namespace romano::firmware
