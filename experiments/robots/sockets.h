// The real world as clients see it: UDP sockets, the machine's monotonic clock, timers of Asio.
// With a key, its ports speak protected packets or DTLS.
#pragma once

#include <boost/asio/io_context.hpp>
#include <memory>
#include <string>
#include <utility>

#include "experiments/robots/surroundings.h"
#include "romano/keys/client_packets.h"

namespace romano::experiments {

class Sockets : public Surroundings {
public:
    explicit Sockets(boost::asio::io_context& io,
                     std::shared_ptr<keys::ClientPackets> packets = nullptr)
        : io_(io), packets_(std::move(packets)) {}

    [[nodiscard]] Instant now() const override;
    [[nodiscard]] std::unique_ptr<Port> open_port(const BrokerAddress& broker,
                                                  const std::string& client_id,
                                                  Port::OnDatagram on_datagram) override;
    [[nodiscard]] std::unique_ptr<Alarm> make_alarm(std::function<void()> on_ring) override;

protected:
    /// With the key of `packets`; null: plain.
    [[nodiscard]] std::unique_ptr<Port> open_socket(const BrokerAddress& broker,
                                                    Port::OnDatagram on_datagram,
                                                    std::shared_ptr<keys::ClientPackets> packets);

private:
    boost::asio::io_context& io_;
    std::shared_ptr<keys::ClientPackets> packets_;  // null: plain
};

}  // namespace romano::experiments
