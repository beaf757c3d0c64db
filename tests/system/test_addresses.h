// Addresses that belong to one test alone: loopback addresses that are numbered like its DDS
// domain, which is locked against all other tests on the machine.
#pragma once

#include <string>

#include "broker/net/endpoint_text.h"
#include "tests/overlay/dds/test_domain.h"

namespace romano::system {

class TestAddresses {
public:
    [[nodiscard]] std::uint32_t domain() const { return domain_.id(); }

    /// "127.77.DOMAIN.N:18830"
    [[nodiscard]] std::string service(int n) const { return host(n) + ":18830"; }
    [[nodiscard]] Endpoint service_endpoint(int n) const {
        return *net::parse_endpoint(service(n));
    }
    /// Where a client sits; its port is the kernel's choice.
    [[nodiscard]] Endpoint client() const { return *net::parse_endpoint(host(200) + ":0"); }

private:
    [[nodiscard]] std::string host(int n) const {
        return "127.77." + std::to_string(domain_.id()) + "." + std::to_string(n);
    }

    dds::TestDomain domain_;
};

}  // namespace romano::system
