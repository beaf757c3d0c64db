// A broker that answers, with a return code: what that means, in words.
#pragma once

#include <optional>
#include <string>

#include "experiments/cli/broker_options.h"
#include "romano/mqttsn/types.h"

namespace romano::experiments {

/// "congestion: it is full or overloaded; ask again later"
[[nodiscard]] std::string words_for(mqttsn::ReturnCode code);

/// The sentence for a command whose client cannot go on: the broker refused it, or does not answer.
[[nodiscard]] std::string why_not(const BrokerOptions& broker,
                                  std::optional<mqttsn::ReturnCode> denial, bool was_refused);

}  // namespace romano::experiments
