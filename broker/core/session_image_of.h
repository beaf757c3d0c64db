// A live session as the image that another home could go on from.
#pragma once

#include "broker/core/session.h"
#include "broker/core/session_image.h"
#include "broker/core/tables.h"

namespace romano::broker {

/// Without `worked_through`: for the own log, in whose order that is implied.
[[nodiscard]] SessionImage bare_image_of(const Session& session);

[[nodiscard]] SessionImage image_of(const Session& session, const Tables& tables);

}  // namespace romano::broker
