// A live session as the image that another home could go on from.
#pragma once

#include <vector>

#include "broker/core/session.h"
#include "broker/core/session_image.h"
#include "broker/core/tables.h"

namespace romano::broker {

/// Without `worked_through`: for the own log, in whose order that is implied.
[[nodiscard]] SessionImage bare_image_of(const Session& session);

/// How far this broker has worked through each log, its own included.
[[nodiscard]] std::vector<LogPosition> worked_through(const Tables& tables);

[[nodiscard]] SessionImage image_of(const Session& session, const Tables& tables);

}  // namespace romano::broker
