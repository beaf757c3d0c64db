// --metrics and --web: where HTTP is served, and what keeps strangers out beyond this machine.
#pragma once

#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "broker/daemon/settings.h"
#include "broker/https/gate.h"

namespace romano::daemon {

/// Empty: not served. Throw Refusal.
[[nodiscard]] std::optional<MetricsSettings> check_metrics(const SettingTexts& texts);
[[nodiscard]] std::optional<WebSettings> check_web(const SettingTexts& texts,
                                                   const std::vector<Endpoint>& listen);

/// Reads the files of a gate, for the option that named the token; null without a gate. Throws
/// Refusal.
[[nodiscard]] std::shared_ptr<https::Gate> open_gate(std::string_view token_option,
                                                     const std::optional<https::GateFiles>& files);

}  // namespace romano::daemon
