// Battery or load of this machine, from 0 (spent) to 100 (full, or idle), as a file tells it:
// /sys/class/power_supply/BAT0/capacity is one, and any program may write one.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

namespace romano::daemon {

class ConditionFile {
public:
    /// Throws Refusal when it holds no such number now.
    explicit ConditionFile(std::string path);
    /// What it holds now. Empty when that is no such number: said once, and again after it was one.
    [[nodiscard]] std::optional<std::uint32_t> look();

private:
    [[nodiscard]] std::optional<std::uint32_t> read() const;

    std::string path_;
    bool is_good_ = true;
};

}  // namespace romano::daemon
