// A cluster's peer that only listens: dds_peer DOMAIN. Sends beacons and writes the first_seq of
// each log batch that it hears to stdout, one a line.

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <utility>

#include "overlay/dds/dds_transport.h"

namespace {

using namespace romano;

void beat(boost::asio::steady_timer& timer, dds::DdsTransport& transport) {
    cluster::Heartbeat beacon;
    transport.send({{}, beacon});
    timer.expires_after(std::chrono::milliseconds(10));
    timer.async_wait([&](const auto&) { beat(timer, transport); });
}

}  // namespace

int main(int argc, char** argv) try {
    if (argc != 2) return 2;
    boost::asio::io_context io;
    const dds::Domain domain(
        dds::DomainOptions{static_cast<std::uint32_t>(std::atoi(argv[1])), "lo"});
    const broker::LogId self{broker::broker_id_of("peer"), 1};
    using std::chrono_literals::operator""ms;
    dds::DdsTransport transport(io, domain, self, overlay::Pulses(10ms, 60ms));
    transport.start([](const overlay::Envelope& envelope) {
        if (const auto* batch = std::get_if<cluster::LogBatch>(&envelope.message)) {
            std::cout << batch->first_seq << std::endl;
        }
    });
    boost::asio::steady_timer timer(io);
    beat(timer, transport);
    io.run();
} catch (const std::exception& error) {
    std::cerr << "dds_peer: " << error.what() << std::endl;
    return 2;
}
