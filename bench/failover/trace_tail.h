// The trace of a broker process as it grows: what the broker said, and when.
//
// A broker begins each line with the wall clock, then the monotonic clock in brackets, which all
// processes of a machine share: "2026-01-01 10:00:00.000 [123.456789] info: lost b2".
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "romano/base/time.h"

namespace romano::bench {

struct TraceLine {
    std::optional<Instant> at;  // what goes to stdout has no time
    std::string text;
};

/// Total: any line gives a text.
[[nodiscard]] TraceLine parse_trace_line(std::string_view line);

class TraceTail {
public:
    explicit TraceTail(std::filesystem::path file) : file_(std::move(file)) {}

    /// Reads the complete lines that have come since; all lines so far are in lines().
    void read();
    /// Begins anew: the file will be another process's. What it holds goes behind
    /// earlier_lives().
    void restart();
    [[nodiscard]] std::filesystem::path earlier_lives() const;

    [[nodiscard]] const std::vector<TraceLine>& lines() const { return lines_; }
    /// The first line at or after `since` that begins with `beginning`.
    [[nodiscard]] const TraceLine* find(std::string_view beginning, Instant since) const;
    /// The last line that begins so, whenever.
    [[nodiscard]] const TraceLine* last(std::string_view beginning) const;

private:
    std::filesystem::path file_;
    std::streamoff offset_ = 0;
    std::vector<TraceLine> lines_;
};

}  // namespace romano::bench
