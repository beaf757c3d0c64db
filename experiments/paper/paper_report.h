// The paper's table and figure again, and each number that the paper states beside ours.
#pragma once

#include "experiments/paper/statements.h"
#include "experiments/report/section.h"

namespace romano::experiments {

[[nodiscard]] Section paper_section(const FiguresByBaud& figures);

}  // namespace romano::experiments
