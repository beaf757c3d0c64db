// The first three octets of loopback addresses, as an option's value: brokers that a program starts
// listen at addresses that every machine has.
#pragma once

#include <CLI/CLI.hpp>
#include <boost/asio/ip/address_v4.hpp>
#include <string>

namespace romano {

[[nodiscard]] inline CLI::Validator loopback_network() {
    return {[](const std::string& network) -> std::string {
                boost::system::error_code none;
                const auto address = boost::asio::ip::make_address_v4(network + ".1", none);
                return !none && address.is_loopback() ? "" : "`" + network + "` must be 127.A.B";
            },
            "127.A.B"};
}

}  // namespace romano
