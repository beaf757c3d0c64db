// The settings of the uplink to an MQTT broker, checked.
#pragma once

#include <optional>

#include "broker/daemon/command_line.h"
#include "broker/daemon/settings.h"

namespace romano::daemon {

/// Empty without --uplink. Throws Refusal.
[[nodiscard]] std::optional<UplinkSettings> check_uplink(const SettingTexts& texts);

}  // namespace romano::daemon
