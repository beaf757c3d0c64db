// Looks at all machines of a testbed through ssh, so that the doctor can say what is wrong.
#pragma once

#include <boost/asio/io_context.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "experiments/testbed/doctor.h"
#include "experiments/testbed/host_channel.h"
#include "experiments/testbed/ssh.h"

namespace romano::experiments {

/// The connections to all machines of a testbed.
class Connections {
public:
    explicit Connections(const Testbed& testbed);
    [[nodiscard]] const std::vector<std::unique_ptr<Ssh>>& all() const { return all_; }
    [[nodiscard]] const Ssh& operator[](std::size_t host) const { return *all_[host]; }

private:
    SshFolder folder_;
    std::vector<std::unique_ptr<Ssh>> all_;
};

/// What a machine is before any program of ours is there.
struct Ground {
    std::string trouble;  // a sentence that says what to do; empty: reached, and root
    std::string architecture;
    bool has_programs = false;
};
[[nodiscard]] Ground look_at_ground(const Ssh& ssh);

/// `port` is the brokers'; `tell` hears what is being looked at.
[[nodiscard]] std::vector<HostSeen> examine(const Testbed& testbed, const Connections& connections,
                                            std::uint16_t port,
                                            const std::function<void(const std::string&)>& tell);

/// As doctor.h compares it with the machines'.
[[nodiscard]] std::string own_version();

}  // namespace romano::experiments
