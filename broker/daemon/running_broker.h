// A broker that runs on an io_context, alone or in a cluster: what its program needs of it.
#pragma once

#include <boost/asio/io_context.hpp>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "broker/daemon/settings.h"

namespace romano::metrics {
class Page;
}

namespace romano::daemon {

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

/// Called once, when all addresses of the settings are served, with "127.0.0.1:1883 ...".
using OnServing = std::function<void(const std::string& where)>;

}  // namespace romano::daemon
