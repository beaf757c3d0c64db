#include "experiments/sweep/fault.h"

#include <array>
#include <utility>

namespace romano::experiments {
namespace {

constexpr std::array<std::pair<Fault, std::string_view>, 9> fault_words{{
    {Fault::none, "none"},
    {Fault::kill_leader, "kill-leader"},
    {Fault::kill_home, "kill-home"},
    {Fault::pause, "pause"},
    {Fault::pause_leader, "pause-leader"},
    {Fault::cut, "cut"},
    {Fault::all_but_one, "all-but-one"},
    {Fault::rolling_restart, "rolling-restart"},
    {Fault::rolling_kill, "rolling-kill"},
}};

}  // namespace

std::string_view name_of(Fault fault) {
    for (const auto& [value, name] : fault_words) {
        if (value == fault) return name;
    }
    return "?";
}

std::optional<Fault> fault_named(std::string_view name) {
    for (const auto& [value, known] : fault_words) {
        if (known == name) return value;
    }
    return std::nullopt;
}

std::string fault_names() {
    std::string text;
    for (const auto& [value, name] : fault_words) {
        if (!text.empty()) text += ", ";
        text += name;
    }
    return text;
}

}  // namespace romano::experiments
