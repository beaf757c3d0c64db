// When a client leaves the rest of a block of numbers unused (RobotEnd::skip_block()): a broker
// that restarted after a crash takes it for old.
//
// That is at a CONNECT, when a broker was heard since the last time; or when so many CONNECTs went
// unanswered, because a broker may have heard them all the same. Skipping at each of them would use
// a key up in twelve days without a broker.
#pragma once

#include "romano/base/bytes.h"
#include "romano/mqttsn/frame.h"

namespace romano::protection {

class SkippedBlocks {
public:
    static constexpr unsigned unanswered_connects = 8;

    /// Before each message is sealed: true when the block is to be skipped.
    [[nodiscard]] bool is_due(Bytes message) {
        const auto frame = mqttsn::decode_frame(message);
        if (!frame || frame->type != mqttsn::MsgType::connect) return false;
        if (!was_heard_ && ++connects_ < unanswered_connects) return false;
        was_heard_ = false;
        connects_ = 0;
        return true;
    }
    /// A packet of a broker was opened.
    void on_heard() {
        was_heard_ = true;
        connects_ = 0;
    }

private:
    bool was_heard_ = false;
    unsigned connects_ = 0;
};

}  // namespace romano::protection
