// A member's options as the settings and this machine's clocks have them.
#pragma once

#include "broker/daemon/settings.h"
#include "overlay/member/member.h"

namespace romano::daemon {

/// The addresses are left out: only the shell knows what was bound.
[[nodiscard]] overlay::MemberOptions member_options(const Settings& settings);

}  // namespace romano::daemon
