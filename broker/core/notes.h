// Lines for people about what a client missed: at most one a second, so that the trouble of a
// thousand clients does not fill the trace. The counters tell of all.
#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <utility>

#include "broker/core/actions.h"
#include "romano/base/time.h"

namespace romano::broker {

class Notes {
public:
    /// `text()` makes the line, when there is room for one.
    template <typename Text>
    void say(Instant now, Actions& out, Text&& text) {
        if (now < next_at_) return;
        next_at_ = now + std::chrono::seconds{1};
        out.push(Note{std::make_unique<std::string>(std::forward<Text>(text)())});
    }

private:
    Instant next_at_ = Instant::min();
};

}  // namespace romano::broker
