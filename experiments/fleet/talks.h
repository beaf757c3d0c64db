// Who talks to whom, as far as the messages themselves tell it: from the robots of which broker, on
// which topics, to those of which; and how much.
//
// A level of a topic that may be a robot's id is written {id}, so that a thousand robots that say
// their place are one talk. Bounded, whatever topics there are.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "romano/base/time.h"

namespace romano::experiments {

struct TalkEnds {
    std::string from;   // the home of the robots that say it; empty: no robot, as far as is seen
    std::string topic;  // as it is shown
    std::string to;     // the home of those whose own topic it is; empty: whoever has subscribed

    friend auto operator<=>(const TalkEnds&, const TalkEnds&) = default;
};

class Talk {
public:
    void on_message() { ++now_; }
    /// A second is over; true when the rate is another one.
    bool on_second();
    /// The mean of the last seconds.
    [[nodiscard]] double messages_per_s() const;
    [[nodiscard]] unsigned silent_s() const { return silent_s_; }

private:
    static constexpr std::size_t seconds = 5;

    std::uint32_t now_ = 0;
    std::array<std::uint32_t, seconds> before_{};
    std::size_t next_ = 0;
    unsigned silent_s_ = 0;
};

class Talks {
public:
    static constexpr std::size_t most = 200;
    static constexpr unsigned forgotten_after_s = 30;  // of silence

    /// False: there is no room for another one.
    bool on_message(std::string_view from, std::string_view topic, std::string_view to);
    /// A second is over; true when something changed.
    bool on_second();

    [[nodiscard]] const std::map<TalkEnds, Talk>& all() const { return all_; }

private:
    std::map<TalkEnds, Talk> all_;
};

/// `topic` as it is shown, with {id} for each level that reads as a ROMANO id.
[[nodiscard]] std::string shown_topic(std::string_view topic);

}  // namespace romano::experiments
