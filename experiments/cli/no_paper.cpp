// `romano paper` of a build without ns-3.
#include <stdexcept>

#include "experiments/cli/paper.h"

namespace romano::experiments {

void add_paper(CLI::App& program, int&) {
    CLI::App& command =
        *program.add_subcommand("paper", "The paper's table and figure again (needs ns-3)");
    command.allow_extras();
    command.callback([] {
        throw std::runtime_error(
            "this build has no radio channel: install ns-3 (Debian: libns3-dev) and build again");
    });
}

}  // namespace romano::experiments
