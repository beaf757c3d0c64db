#include "broker/daemon/running_broker.h"

#include "broker/net/endpoint_text.h"

namespace romano::daemon {

std::string words_for(const Serving& serving) {
    std::string out;
    for (const Endpoint& address : serving.addresses) {
        out += (out.empty() ? "" : ", ") + net::to_text(address);
    }
    return serving.cluster.empty() ? out : out + " (" + serving.cluster + ")";
}

}  // namespace romano::daemon
