// Brokers and robots on the machines of a testbed that go on when this program has ended: `romano
// testbed start`, `stop`.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "experiments/testbed/examination.h"
#include "experiments/testbed/program_order.h"

namespace romano::experiments {

/// What is kept running on one machine.
[[nodiscard]] KeptPrograms programs_of(const Testbed& testbed, const Host& host);

/// A sentence for each machine that has trouble, with its name; none: all brokers serve. With
/// trouble, nothing stays started.
[[nodiscard]] std::vector<std::string> start_fleet(
    const Testbed& testbed, const Connections& connections,
    const std::function<void(const std::string&)>& tell);
[[nodiscard]] std::vector<std::string> stop_fleet(
    const Testbed& testbed, const Connections& connections,
    const std::function<void(const std::string&)>& tell);

}  // namespace romano::experiments
