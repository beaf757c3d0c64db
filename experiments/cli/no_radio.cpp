// `romano paper` and `romano cell` of a build without ns-3.
#include <stdexcept>
#include <string>

#include "experiments/cli/cell.h"
#include "experiments/cli/paper.h"

namespace romano::experiments {
namespace {

void add(CLI::App& program, const std::string& name, const std::string& what) {
    CLI::App& command = *program.add_subcommand(name, what + " (needs ns-3)");
    command.allow_extras();
    command.callback([] {
        throw std::runtime_error(
            "this build has no radio channel: install ns-3 (Debian: libns3-dev) and build again");
    });
}

}  // namespace

void add_paper(CLI::App& program, int&) {
    add(program, "paper", "The paper's table and figure again");
}

void add_cell(CLI::App& program, int&) {
    add(program, "cell", "Modelled radio cells between real robots and real brokers");
}

}  // namespace romano::experiments
