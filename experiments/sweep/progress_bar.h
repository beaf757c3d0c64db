// How far a sweep is. On a terminal a bar with the time that is left, redrawn in place; else one
// line a finished cell, as a log wants it.
#pragma once

#include <chrono>
#include <cstdio>
#include <string>
#include <string_view>

namespace romano::experiments {

class ProgressBar {
public:
    using Clock = std::chrono::steady_clock;

    /// `done` of `total` cells were done before.
    ProgressBar(std::FILE* out, std::size_t total, std::size_t done);
    ~ProgressBar();
    ProgressBar(const ProgressBar&) = delete;
    ProgressBar& operator=(const ProgressBar&) = delete;

    /// `share` of the running cell is over; `doing` says what it is about.
    void show(double share, std::string_view doing);
    /// A cell is done: `line` stays on the screen.
    void finish_cell(std::string_view line);
    /// A cell is done, and nothing is to be said of it.
    void finish_quietly() { ++done_; }
    /// Room for other output on the terminal.
    void erase();

private:
    std::FILE* out_;
    bool terminal_;
    std::size_t total_;
    std::size_t done_;
    std::size_t done_before_;
    Clock::time_point started_ = Clock::now();
    Clock::time_point shown_{};
};

/// "[#####.....]": `share` from 0 to 1.
[[nodiscard]] std::string bar_of(double share, std::size_t width);
/// "45 s", "3 min 05 s", "2 h 10 min".
[[nodiscard]] std::string duration_text(std::chrono::seconds duration);

}  // namespace romano::experiments
