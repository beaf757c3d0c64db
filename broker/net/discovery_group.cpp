#include "broker/net/discovery_group.h"

#include "broker/net/endpoint_text.h"

namespace romano::net {

std::vector<Endpoint> usual_discovery_groups() {
    return {*parse_endpoint("225.1.1.1:1883"), *parse_endpoint("[ff02::225:1:1:1]:1883")};
}

}  // namespace romano::net
