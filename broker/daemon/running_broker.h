// A broker that runs on an io_context, alone or in a cluster: what its program needs of it.
#pragma once

#include <boost/asio/io_context.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "broker/daemon/settings.h"

namespace romano::metrics {
class Page;
}

namespace romano::daemon {

/// Thrown while the io_context runs: this life of the broker is over, and another one begins.
struct BeginsAgain {
    std::uint64_t least_incarnation = 0;  // of the next one's log
};

class RunningBroker {
public:
    virtual ~RunningBroker() = default;
    /// An orderly stop; the io_context has nothing left to do soon afterwards.
    virtual void leave() = 0;
    /// SIGHUP: the rights may have changed.
    virtual void read_rights_again() = 0;
    /// What it counted, for --metrics.
    virtual void add_metrics(metrics::Page& page) const = 0;
};

/// The addresses of the settings, with the ports that were chosen for port 0.
struct Serving {
    std::vector<Endpoint> addresses;
    std::string cluster = {};  // "domain 7 on lo"; empty: alone
};
/// "127.0.0.1:1883, [::1]:1883 (domain 7 on lo)"
[[nodiscard]] std::string words_for(const Serving& serving);

/// Called once, when all of them are served.
using OnServing = std::function<void(const Serving&)>;

}  // namespace romano::daemon
