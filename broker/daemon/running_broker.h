// A broker that runs on an io_context, alone or in a cluster: what main() needs of it.
#pragma once

#include <boost/asio/io_context.hpp>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "broker/daemon/settings.h"

namespace romano::daemon {

class RunningBroker {
public:
    virtual ~RunningBroker() = default;
    /// An orderly stop; the io_context has nothing left to do soon afterwards.
    virtual void leave() = 0;
};

/// Called once, when all addresses of the settings are served, with "127.0.0.1:1883 ...".
using OnServing = std::function<void(const std::string& where)>;

/// Throws Refusal when a setting turns out to be impossible; nothing runs then.
[[nodiscard]] std::unique_ptr<RunningBroker> start_broker(boost::asio::io_context& io,
                                                          const Settings& settings,
                                                          OnServing on_serving);

}  // namespace romano::daemon
