#include "overlay/daemon/condition_file.h"

#include <spdlog/spdlog.h>

#include <fstream>

#include "broker/daemon/refusal.h"
#include "overlay/cluster/agreement/condition.h"

namespace romano::daemon {

ConditionFile::ConditionFile(std::string path) : path_(std::move(path)) {
    if (!read()) {
        throw Refusal("--condition-file '" + path_ +
                      "': must be a file that holds a whole number from 0 to 100, for example "
                      "/sys/class/power_supply/BAT0/capacity");
    }
}

std::optional<std::uint32_t> ConditionFile::look() {
    const auto reading = read();
    if (!reading && is_good_) {
        spdlog::warn("{} holds no whole number from 0 to 100 any more; what it held last counts",
                     path_);
    }
    is_good_ = reading.has_value();
    return reading;
}

std::optional<std::uint32_t> ConditionFile::read() const {
    std::ifstream file(path_);
    std::int64_t number = -1;
    std::string more;
    if (!(file >> number) || number < 0 || number > cluster::Condition::best) return std::nullopt;
    if (file >> more) return std::nullopt;
    return static_cast<std::uint32_t>(number);
}

}  // namespace romano::daemon
