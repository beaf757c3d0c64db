// Ends the loops in which other robots control a robot (romano/control): a robot that is to stand
// still must not take the next command of its controller. A loop is ended by its number, so the
// robot is asked for each of its channels first.
#pragma once

#include <deque>
#include <map>
#include <utility>
#include <vector>

#include "experiments/operator/robot_message.h"
#include "romano/base/bytes.h"
#include "romano/base/time.h"
#include "romano/control/messages.h"
#include "romano/message/romano_id.h"

namespace romano::experiments {

class LoopStop {
public:
    /// `self`: on whose topic robots answer.
    explicit LoopStop(const message::RomanoId& self) : self_(self) {}

    struct ToRobot {
        message::RomanoId robot;
        Octets octets;
    };
    /// What to say to the robot first. Its answers count for some seconds from now.
    [[nodiscard]] ToRobot begin(Instant now, const message::RomanoId& robot);
    /// What came on the own topic; what to say then.
    [[nodiscard]] std::vector<ToRobot> on_answer(Instant now, Bytes data);

    [[nodiscard]] const message::RomanoId& self() const { return self_; }

private:
    [[nodiscard]] ToRobot ask(const message::RomanoId& robot, control::Channel channel) const;

    message::RomanoId self_;
    std::map<message::RomanoId, Instant> begun_;
    std::deque<std::pair<Instant, message::RomanoId>> in_order_;  // the oldest first
};

}  // namespace romano::experiments
