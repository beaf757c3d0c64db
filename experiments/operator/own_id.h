// The id under which the programs of this machine ask robots for something.
#pragma once

#include "romano/message/romano_id.h"

namespace romano::experiments {

/// The same each time, for a robot keeps the topic of each asker, and has room for a dozen.
[[nodiscard]] message::RomanoId id_of_this_machine();

}  // namespace romano::experiments
