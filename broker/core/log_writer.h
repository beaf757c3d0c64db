// The pen of the own log: numbers events and puts them into the actions.
//
// Without a log (BrokerOptions::writes_log) nothing is even built: callers pass a function that
// makes the event.
#pragma once

#include <utility>

#include "broker/core/actions.h"

namespace romano::broker {

class LogWriter {
public:
    LogWriter(LogId log, bool writes) : log_(log), writes_(writes) {}

    template <typename MakeEvent>
    void append(Actions& out, MakeEvent&& make_event) {
        if (!writes_) return;
        ++last_;
        out.push(Append{last_, LogEvent{make_event()}});
    }

    /// Of the next event; seq 0 when there is no log.
    [[nodiscard]] LogPosition next_position() const { return {log_, writes_ ? last_ + 1 : 0}; }
    [[nodiscard]] Seq last() const { return last_; }
    [[nodiscard]] LogId id() const { return log_; }
    [[nodiscard]] bool writes() const { return writes_; }

private:
    LogId log_;
    bool writes_;
    Seq last_ = 0;
};

}  // namespace romano::broker
