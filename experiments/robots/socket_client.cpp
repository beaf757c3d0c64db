#include "experiments/robots/socket_client.h"

#include <stdexcept>

namespace romano::experiments {

BrokerAddress resolve_broker(boost::asio::io_context& io, const std::string& host,
                             std::uint16_t port) {
    using boost::asio::ip::udp;
    boost::system::error_code error;
    udp::resolver resolver(io);
    const auto found =
        resolver.resolve(host, std::to_string(port), udp::resolver::numeric_service, error);
    if (error || found.empty()) {
        throw std::runtime_error("cannot find the host `" + host + "`: " + error.message());
    }
    return found.begin()->endpoint();
}

}  // namespace romano::experiments
