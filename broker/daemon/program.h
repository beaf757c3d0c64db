// What the two programs share: romano-broker, which is a broker alone, and romano-broker-member,
// which romano-broker becomes (exec) when it is given a --domain. So a broker alone carries neither
// DDS nor Protobuf in its memory, and people know one command.
#pragma once

#include <functional>

#include "broker/daemon/running_broker.h"

namespace romano::daemon {

struct Program {
    /// Called with the settings before anything is started.
    std::function<void(const Settings&)> prepare;
    /// Throws Refusal when a setting turns out to be impossible; nothing runs then.
    std::function<std::unique_ptr<RunningBroker>(boost::asio::io_context&, const Settings&,
                                                 OnServing)>
        start;
};

/// Reads the settings, runs one broker until SIGTERM or SIGINT; the exit code.
int run_program(int argc, const char* const* argv, const Program& program);

}  // namespace romano::daemon
