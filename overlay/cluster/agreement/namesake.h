// Another process has our name. Brokers are told apart by their names alone, so the two are one to
// everybody else, who takes what they say in turns: messages are lost, until people give one of
// them another name.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "overlay/cluster/ownership/service_address.h"
#include "romano/base/time.h"

namespace romano::cluster {

class Namesake {
public:
    /// A message came from a broker of our name. What people should be told: nothing of a few last
    /// words of our former life, and then not often.
    std::optional<Notice> on_message(Instant now, Duration told_every, const std::string& name,
                                     std::uint64_t own_process, std::uint64_t process) {
        if (process == own_process) return std::nullopt;
        if (std::exchange(process_, process) != process) messages_ = 0;
        if (++messages_ < least_messages || now < told_again_at_) return std::nullopt;
        told_again_at_ = now + told_every;
        return Notice{.text = "another broker is named " + name +
                              ", too: messages will be lost; give each its own --name",
                      .is_warning = true};
    }

private:
    static constexpr std::uint64_t least_messages = 20;

    std::uint64_t process_ = 0;
    std::uint64_t messages_ = 0;  // of that process
    Instant told_again_at_ = Instant::min();
};

}  // namespace romano::cluster
