// What the ROMANO paper states in numbers, beside what came out here, how they differ, and why:
// each reason is computed from the runs that it explains.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "experiments/paper/paper_run.h"

namespace romano::experiments {

struct Range {
    double least = 0;
    double most = 0;
};

/// One rate of the paper's table, over all runs; delivery in percent.
struct DeliveryFigures {
    std::size_t runs = 0;
    std::size_t messages = 0;       // of each run
    Range goes_on;                  // the router loses what it has no room for, and goes on
    Range stops;                    // it takes nothing more after its first overflow
    std::size_t overflowed = 0;     // runs
    std::optional<Range> overflow;  // after so many messages
    std::optional<Range> until_overflow;
    std::optional<double> carried_per_s;  // mean of the runs that overflowed
    std::size_t given_up_on_air = 0;      // frames of all runs
};
[[nodiscard]] DeliveryFigures figures_of(const std::vector<DeliveryRun>& runs);

/// Of one UART rate of the border router.
struct PaperFigures {
    std::map<double, DeliveryFigures> delivery;            // by rate
    std::map<std::size_t, std::vector<RobotDelay>> delay;  // by the number of robots
};
using FiguresByBaud = std::map<std::uint32_t, PaperFigures>;

/// Our side of a statement.
struct Finding {
    std::uint32_t router_baud = 0;
    std::string reading;  // of what the router does after an overflow, where it matters
    Range ours;           // over the runs, or over the messages
    double compared = 0;  // of them, with the paper's number
    std::string verdict;
};

struct Statement {
    std::string what;
    std::string unit;
    double papers = 0;
    bool at_least = false;  // the paper's number is a bound
    std::vector<Finding> findings;
};
/// Those that the figures can speak to.
[[nodiscard]] std::vector<Statement> statements_of(const FiguresByBaud& figures);

/// For the figure: the table's rates, and the delay of the robot that is served after `before`.
struct PapersDelivery {
    double rate;
    double least;
    double most;
};
[[nodiscard]] std::vector<PapersDelivery> papers_deliveries();
[[nodiscard]] double papers_delay_ms(std::size_t before);

[[nodiscard]] double difference_percent(const Statement& statement, const Finding& finding);

}  // namespace romano::experiments
