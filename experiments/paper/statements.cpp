#include "experiments/paper/statements.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <span>
#include <string_view>
#include <utility>

#include "experiments/report/summary_table.h"
#include "overlay/radio/serial_line.h"

namespace romano::experiments {
namespace {

constexpr double tolerance_percent = 10;
constexpr double hundred = 100;

/// The paper's table "Message Delivery Ratio for Different Message Generation Rates".
struct PapersRow {
    double rate;
    double minimum;
    double maximum;
    std::optional<double> overflow_after;
};
constexpr std::array papers_table{
    PapersRow{100, 99.9, 100, std::nullopt}, PapersRow{200, 99.5, 100, std::nullopt},
    PapersRow{300, 44, 100, 2200}, PapersRow{400, 15, 100, 1300}, PapersRow{500, 13, 96, 600}};
/// "We find that the message delivery percentage is >= 99.5 % for a messaging rate of 200 MPS or
/// less", and "until the radio buffer overflows".
constexpr double papers_delivery = 99.5;
constexpr std::array papers_other_rates{1.0, 10.0, 20.0, 50.0, 75.0};
constexpr double papers_first_ms = 20;
constexpr double papers_step_ms = 8;

constexpr std::size_t publish_octets = 39;  // MQTT-SN's 7 and the paper's 32

double line_ms(std::uint32_t baud, const radio::Framing& framing) {
    const std::vector<std::uint8_t> datagram(publish_octets, 'x');
    return std::chrono::duration<double, std::milli>(radio::line_time(baud, framing, datagram))
        .count();
}

std::string per_second(double rate) {
    return number_text(rate, rate == std::round(rate) ? 0 : 1) + "/s";
}

/// "its UART carries 110/s (9.1 ms a message)", from what the overflowed runs carried.
std::string limit_text(std::uint32_t baud, double carried_per_s) {
    constexpr double same = 0.02;
    const double line = line_ms(baud, radio::ethernet_over_serial);
    const bool is_line = std::abs(1e3 / carried_per_s - line) < same * line;
    return std::string{is_line ? "the router's UART" : "the radio"} + " carries " +
           number_text(carried_per_s, 0) + "/s (" + number_text(1e3 / carried_per_s, 1) +
           " ms a message)";
}

bool is_near(double papers, double ours) {
    return std::abs(ours - papers) <= tolerance_percent / hundred * papers;
}

std::string runs_text(const DeliveryFigures& figures) {
    return std::to_string(figures.overflowed) + " of " + std::to_string(figures.runs) +
           " runs overflowed";
}

/// Why delivery is lower or higher than the paper's.
std::string why_delivery(std::uint32_t baud, double rate, const DeliveryFigures& figures,
                         double papers, double ours) {
    if (figures.overflowed == 0) {
        return ours < papers ? "no run overflowed; " + std::to_string(figures.given_up_on_air) +
                                   " frames were given up on the air"
                             : "no run overflowed: nothing was lost before the radio";
    }
    std::string why = runs_text(figures);
    if (!figures.carried_per_s) return why + ", shortly before they ended";
    why += ": " + limit_text(baud, *figures.carried_per_s);
    if (ours > papers) return why + ", also after the queue is full";
    const double short_of = 1 - *figures.carried_per_s / rate;
    const double room =
        papers / hundred * static_cast<double>(figures.messages) * std::max(short_of, 0.0);
    return why + "; for the paper's a queue would have to hold " + number_text(room, 0);
}

/// Why a router that stops delivers another share than the paper's.
std::string why_stopped(const DeliveryFigures& figures, const PapersRow& row) {
    std::string why = "overflow after " + number_text(figures.overflow->least, 0) + " of " +
                      std::to_string(figures.messages);
    if (row.overflow_after) {
        const double papers_share = hundred * *row.overflow_after / papers_messages;
        why += "; the paper's own overflow after " + number_text(*row.overflow_after, 0) + " of " +
               std::to_string(papers_messages) + " is " + number_text(papers_share, 0) + " %";
    }
    return why;
}

std::string why_overflow(std::uint32_t baud, double rate, const DeliveryFigures& figures,
                         double papers) {
    if (!figures.carried_per_s) return "the runs ended shortly after it";
    const double short_of = 1 - *figures.carried_per_s / rate;
    return limit_text(baud, *figures.carried_per_s) + " and a queue of " +
           number_text(figures.overflow->least * short_of, 0) +
           " was full then; the paper's number needs one of " + number_text(papers * short_of, 0);
}

class Statements {
public:
    explicit Statements(const FiguresByBaud& figures) : figures_(figures) {
        for (const double rate : papers_other_rates) {
            add_delivery({rate, papers_delivery, 0, std::nullopt}, true);
        }
        for (const PapersRow& row : papers_table) {
            add_delivery(row, false);
            add_most_delivery(row);
            if (!row.overflow_after) continue;
            add_overflow(row);
            add_until_overflow(row);
        }
        add_delays();
        std::erase_if(statements_,
                      [](const Statement& statement) { return statement.findings.empty(); });
    }
    std::vector<Statement> take() && { return std::move(statements_); }

private:
    Statement& add(std::string what, std::string unit, double papers) {
        return statements_.emplace_back(Statement{.what = std::move(what),
                                                  .unit = std::move(unit),
                                                  .papers = papers,
                                                  .at_least = false,
                                                  .findings = {}});
    }
    static void find(Statement& statement, std::uint32_t baud, std::string reading,
                     const Range& ours, double compared, const std::string& why_not) {
        std::string verdict = why_not;
        if (statement.at_least && compared >= statement.papers) {
            verdict = "holds";
        } else if (!statement.at_least && is_near(statement.papers, compared)) {
            verdict = "within 10 %";
        }
        statement.findings.push_back(
            {baud, std::move(reading), ours, compared, std::move(verdict)});
    }
    /// `use` gets baud and figures of each baud that has this rate.
    template <typename Use>
    void each(double rate, Use use) const {
        for (const auto& [baud, figures] : figures_) {
            const auto found = figures.delivery.find(rate);
            if (found != figures.delivery.end()) use(baud, found->second);
        }
    }

    void add_delivery(const PapersRow& row, bool at_least) {
        Statement& statement = add("least delivery at " + per_second(row.rate), "%", row.minimum);
        statement.at_least = at_least;
        each(row.rate, [&](std::uint32_t baud, const DeliveryFigures& ours) {
            const auto why = [&](double least) {
                return why_delivery(baud, row.rate, ours, row.minimum, least);
            };
            if (ours.overflowed == 0) {
                find(statement, baud, "", ours.goes_on, ours.goes_on.least,
                     why(ours.goes_on.least));
                return;
            }
            find(statement, baud, "goes on", ours.goes_on, ours.goes_on.least,
                 why(ours.goes_on.least));
            find(statement, baud, "stops", ours.stops, ours.stops.least, why_stopped(ours, row));
        });
    }

    void add_most_delivery(const PapersRow& row) {
        Statement& statement = add("most delivery at " + per_second(row.rate), "%", row.maximum);
        each(row.rate, [&](std::uint32_t baud, const DeliveryFigures& ours) {
            find(statement, baud, ours.overflowed == 0 ? "" : "goes on", ours.goes_on,
                 ours.goes_on.most,
                 why_delivery(baud, row.rate, ours, row.maximum, ours.goes_on.most));
        });
    }

    void add_overflow(const PapersRow& row) {
        Statement& statement =
            add("overflow at " + per_second(row.rate) + " after", "messages", *row.overflow_after);
        each(row.rate, [&](std::uint32_t baud, const DeliveryFigures& ours) {
            if (!ours.overflow) return;
            find(statement, baud, "", *ours.overflow,
                 (ours.overflow->least + ours.overflow->most) / 2,
                 why_overflow(baud, row.rate, ours, statement.papers));
        });
    }

    void add_until_overflow(const PapersRow& row) {
        Statement& statement =
            add("delivery until the overflow at " + per_second(row.rate), "%", papers_delivery);
        each(row.rate, [&](std::uint32_t baud, const DeliveryFigures& ours) {
            if (!ours.until_overflow) return;
            find(statement, baud, "", *ours.until_overflow, ours.until_overflow->least,
                 std::to_string(ours.given_up_on_air) + " frames were given up on the air");
        });
    }

    void add_delays() {
        Statement& first = add("delay of the first robot", "ms", papers_first_ms);
        Statement step{"more for each further robot", "ms", papers_step_ms, false, {}};
        for (const auto& [baud, figures] : figures_) {
            if (figures.delay.empty() || figures.delay.rbegin()->second.empty()) continue;
            const std::span<const RobotDelay> robots = figures.delay.rbegin()->second;
            const double router = line_ms(baud, radio::ethernet_over_serial);
            const double robot = line_ms(papers_robot_baud, radio::robots_hdlc);
            const double mean = robots.front().mean;
            find(first, baud, "", {robots.front().least, robots.front().most}, mean,
                 "the router's UART takes " + number_text(router, 1) + " ms, the robot's " +
                     number_text(robot, 1) + ", the air and the wire " +
                     number_text(mean - router - robot, 1));
            if (robots.size() < 2) continue;
            Range steps{robots[1].mean - robots[0].mean, robots[1].mean - robots[0].mean};
            for (std::size_t i = 2; i < robots.size(); ++i) {
                const double more = robots[i].mean - robots[i - 1].mean;
                steps = {std::min(steps.least, more), std::max(steps.most, more)};
            }
            const double more =
                (robots.back().mean - mean) / static_cast<double>(robots.size() - 1);
            find(step, baud, "", steps, more,
                 "one more message waits: " + limit_text(baud, 1e3 / more));
        }
        statements_.push_back(std::move(step));
    }

    static constexpr std::uint32_t papers_robot_baud = 115'200;

    const FiguresByBaud& figures_;
    std::vector<Statement> statements_;
};

void widen(Range& range, bool is_first, double value) {
    range.least = is_first ? value : std::min(range.least, value);
    range.most = is_first ? value : std::max(range.most, value);
}

}  // namespace

DeliveryFigures figures_of(const std::vector<DeliveryRun>& runs) {
    DeliveryFigures figures;
    double carried = 0;
    std::size_t carrying = 0;
    for (const DeliveryRun& run : runs) {
        const auto percent = [](std::size_t part, std::size_t of) {
            return of == 0 ? 0 : hundred * static_cast<double>(part) / static_cast<double>(of);
        };
        const bool is_first = figures.runs++ == 0;
        figures.messages = run.sent;
        widen(figures.goes_on, is_first, percent(run.delivered, run.sent));
        widen(figures.stops, is_first, percent(run.delivered_if_it_stops, run.sent));
        figures.given_up_on_air += run.given_up_on_air;
        if (run.carried_per_s) {
            carried += *run.carried_per_s;
            ++carrying;
        }
        if (!run.overflow_after) continue;
        const bool is_first_overflow = figures.overflowed++ == 0;
        if (is_first_overflow) {
            figures.overflow.emplace();
            figures.until_overflow.emplace();
        }
        widen(*figures.overflow, is_first_overflow, static_cast<double>(*run.overflow_after));
        widen(*figures.until_overflow, is_first_overflow,
              percent(run.delivered_if_it_stops, *run.overflow_after));
    }
    if (carrying > 0) figures.carried_per_s = carried / static_cast<double>(carrying);
    return figures;
}

std::vector<Statement> statements_of(const FiguresByBaud& figures) {
    return Statements(figures).take();
}

std::vector<PapersDelivery> papers_deliveries() {
    std::vector<PapersDelivery> rows;
    for (const PapersRow& row : papers_table) rows.push_back({row.rate, row.minimum, row.maximum});
    return rows;
}

double papers_delay_ms(std::size_t before) {
    return papers_first_ms + papers_step_ms * static_cast<double>(before);
}

double difference_percent(const Statement& statement, const Finding& finding) {
    return hundred * (finding.compared - statement.papers) / statement.papers;
}

}  // namespace romano::experiments
