#include "experiments/cli/simulate.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "election/elector.h"
#include "election/failure_detector.h"
#include "election/profile.h"
#include "experiments/report/summary_table.h"
#include "experiments/sweep/progress_bar.h"
#include "overlay/sim/run.h"

namespace romano::experiments {
namespace {

constexpr const char* simulate_examples = R"(Examples:
  romano simulate --seeds 1..1000                  (clusters of 2 to 5 brokers, every kind of fault)
  romano simulate --seeds 1..200 --fault crash --brokers 3 --acks 1
  romano simulate --seeds 1..100 --elector raft --json | jq .runs.bad
  romano simulate --seeds 1..5000 --as-shipped --invariants      (profiles, detectors and electors, too)
  romano simulate --seeds 17 --trace | less        (one run, all that happens in it)
A seed is one cluster with its robots, their traffic and its faults: the same seed and options are
the same run, byte for byte. What is simulated and judged: overlay/sim/README.md.
Exit code: 0; 1 when a promise was broken (with the command that repeats it); 2 when nothing was run.
)";

constexpr const char* promises[] = {
    "",
    "P1 one leader",
    "P2 nothing acknowledged is lost",
    "P3 QoS 2 exactly once",
    "P4 one home a client",
    "P5 in order",
    "P6 same state everywhere",
    "P7 wills",
    "P8 bounded",
    "liveness",
    "no number twice under one key",
    "rights kept",
};

std::optional<std::uint64_t> number_of(std::string_view text) {
    std::uint64_t number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
    return number;
}

/// "1..100" or "17".
std::optional<sim::SeedRange> range_of(const std::string& text) {
    const auto dots = text.find("..");
    const auto first = number_of(text.substr(0, dots));
    const auto last = dots == std::string::npos ? first : number_of(text.substr(dots + 2));
    if (!first || !last || *last < *first) return std::nullopt;
    return sim::SeedRange{*first, *last};
}

std::vector<std::string> words(std::span<const std::string_view> names) {
    return {names.begin(), names.end()};
}

std::vector<std::string> profile_names() {
    std::vector<std::string> names;
    for (const auto& profile : election::profiles) names.emplace_back(profile.name);
    return names;
}

struct SimulateOptions {
    std::string seeds = "1..100";
    std::string acks;
    std::vector<std::string> faults;
    bool as_json = false;
    bool trace = false;
    bool invariants = false;
    sim::RunOptions run;
    std::int64_t faults_last_ms = 0;  // 0: as run says
};

/// What the runs came to, together and by the kinds of fault that happened in them.
class Tally {
public:
    void add(const sim::RunResult& run, const sim::RunOptions& options) {
        all_.add(run, 1);
        for (std::size_t kind = 0; kind < sim::fault_kinds; ++kind) {
            if (run.faults[kind] > 0) by_fault_[kind].add(run, run.faults[kind]);
        }
        acknowledged_ += run.acknowledged;
        received_ += run.received;
        virtual_time_ += run.virtual_time;
        for (const auto& violation : run.violations) {
            ++broken_[static_cast<std::size_t>(violation.promise)];
        }
        Row& configuration = by_configuration_[{run.profile, run.detector, run.elector}];
        configuration.add(run, 1);
        for (std::size_t i = 0; i < sim::invariant_count; ++i) {
            if (run.breaches[i].empty()) continue;
            all_.add_breach(i);
            configuration.add_breach(i);
            examples_[i].try_emplace(run.seed, run.breaches[i]);
        }
        if (!run.is_good()) {
            failures_.push_back({{"seed", run.seed},
                                 {"setting", run.setting},
                                 {"violations", violations_of(run)},
                                 {"command", sim::replay_command(run.seed, options)}});
        }
    }

    void print() const {
        SummaryTable table{.head = {"fault", "times", "runs", "bad runs"}, .units = {}, .rows = {}};
        for (std::size_t kind = 0; kind < sim::fault_kinds; ++kind) {
            const Row& row = by_fault_[kind];
            if (row.runs == 0) continue;
            table.rows.push_back({std::string{sim::fault_names[kind]}, std::to_string(row.times),
                                  std::to_string(row.runs), std::to_string(row.bad)});
        }
        table.rows.push_back({"all", "", std::to_string(all_.runs), std::to_string(all_.bad)});
        std::fputs(to_text(table).c_str(), stdout);
        std::printf("\n%llu messages acknowledged, %llu received, in %.0f s of virtual time\n",
                    static_cast<unsigned long long>(acknowledged_),
                    static_cast<unsigned long long>(received_), seconds());
        for (std::size_t promise = 0; promise < broken_.size(); ++promise) {
            if (broken_[promise] > 0) {
                std::printf("broken %u times: %s\n", broken_[promise], promises[promise]);
            }
        }
    }

    /// In how many runs each invariant broke, by what was searched.
    void print_invariants() const {
        SummaryTable table{
            .head = {"profile", "detector", "elector", "runs", "bad"}, .units = {}, .rows = {}};
        for (const std::string_view name : sim::invariant_names) {
            table.head.emplace_back(name.substr(0, name.find(' ')));
        }
        const auto add = [&](std::vector<std::string> row, const Row& counted) {
            row.push_back(std::to_string(counted.runs));
            row.push_back(std::to_string(counted.bad));
            for (const std::uint32_t broken : counted.broken) row.push_back(std::to_string(broken));
            table.rows.push_back(std::move(row));
        };
        for (const auto& [configuration, row] : by_configuration_) {
            const auto& [profile, detector, elector] = configuration;
            add({profile.empty() ? "-" : profile, detector, elector}, row);
        }
        add({"all", "", ""}, all_);
        std::printf("\nRuns in which an invariant broke:\n%s", to_text(table).c_str());
        for (std::size_t i = 0; i < sim::invariant_count; ++i) {
            if (examples_[i].empty()) continue;
            const auto& [seed, what] = *examples_[i].begin();
            std::printf("%s: seed %llu, %s\n", std::string{sim::invariant_names[i]}.c_str(),
                        static_cast<unsigned long long>(seed), what.c_str());
        }
    }

    void print_json() const {
        nlohmann::ordered_json faults = nlohmann::ordered_json::object();
        for (std::size_t kind = 0; kind < sim::fault_kinds; ++kind) {
            const Row& row = by_fault_[kind];
            if (row.runs == 0) continue;
            faults[std::string{sim::fault_names[kind]}] = {
                {"times", row.times}, {"runs", row.runs}, {"bad", row.bad}};
        }
        const nlohmann::ordered_json all{
            {"runs", {{"all", all_.runs}, {"bad", all_.bad}}},
            {"faults", faults},
            {"messages", {{"acknowledged", acknowledged_}, {"received", received_}}},
            {"virtual_time_s", seconds()},
            {"invariants", invariants()},
            {"failures", failures_}};
        std::puts(all.dump(2).c_str());
    }

private:
    struct Row {
        std::uint64_t times = 0;
        std::uint32_t runs = 0;
        std::uint32_t bad = 0;
        std::array<std::uint32_t, sim::invariant_count> broken{};  // runs

        void add(const sim::RunResult& run, std::uint32_t count) {
            times += count;
            ++runs;
            if (!run.is_good()) ++bad;
        }
        void add_breach(std::size_t invariant) { ++broken[invariant]; }
    };

    [[nodiscard]] nlohmann::ordered_json invariants() const {
        nlohmann::ordered_json list = nlohmann::ordered_json::array();
        for (const auto& [configuration, row] : by_configuration_) {
            const auto& [profile, detector, elector] = configuration;
            nlohmann::ordered_json entry{{"profile", profile},
                                         {"detector", detector},
                                         {"elector", elector},
                                         {"runs", row.runs},
                                         {"bad", row.bad}};
            for (std::size_t i = 0; i < sim::invariant_count; ++i) {
                entry["broken"][std::string{sim::invariant_names[i]}] = row.broken[i];
            }
            list.push_back(std::move(entry));
        }
        return list;
    }
    static nlohmann::ordered_json violations_of(const sim::RunResult& run) {
        nlohmann::ordered_json list = nlohmann::ordered_json::array();
        for (const auto& violation : run.violations) {
            list.push_back({{"promise", promises[static_cast<std::size_t>(violation.promise)]},
                            {"what", violation.what}});
        }
        return list;
    }
    [[nodiscard]] double seconds() const {
        return std::chrono::duration<double>(virtual_time_).count();
    }

    Row all_;
    std::array<Row, sim::fault_kinds> by_fault_{};
    using Configuration = std::tuple<std::string, std::string, std::string>;
    std::map<Configuration, Row> by_configuration_;  // profile, detector, elector
    std::array<std::map<std::uint64_t, std::string>, sim::invariant_count> examples_;  // by seed
    std::array<std::uint32_t, std::size(promises)> broken_{};
    std::uint64_t acknowledged_ = 0;
    std::uint64_t received_ = 0;
    Duration virtual_time_{0};
    nlohmann::ordered_json failures_ = nlohmann::ordered_json::array();
};

bool simulate(const SimulateOptions& options) {
    const sim::SeedRange seeds = *range_of(options.seeds);
    sim::RunOptions run = options.run;
    if (!options.acks.empty()) {
        run.acks = options.acks == "all" ? cluster::all_peers
                                         : static_cast<std::uint32_t>(*number_of(options.acks));
    }
    for (const std::string& name : options.faults) run.faults.push_back(*sim::fault_of(name));
    if (options.faults_last_ms > 0) {
        run.faults_last = std::chrono::milliseconds{options.faults_last_ms};
    }
    if (options.trace) {
        run.trace = [](std::string_view line) {
            std::printf("%.*s\n", static_cast<int>(line.size()), line.data());
        };
    }

    Tally tally;
    ProgressBar bar{stderr, static_cast<std::size_t>(seeds.last - seeds.first + 1), 0};
    const bool good = sim::run_seeds(seeds, run, [&](const sim::RunResult& result) {
        tally.add(result, run);
        if (result.is_good()) {
            bar.finish_quietly();
        } else {
            bar.finish_cell("seed " + std::to_string(result.seed) + " is bad (" + result.setting +
                            ")\n" + to_text(result.violations) +
                            "again: " + sim::replay_command(result.seed, run));
        }
        bar.show(0, "seeds");
    });
    bar.erase();
    options.as_json ? tally.print_json() : tally.print();
    if (options.invariants && !options.as_json) tally.print_invariants();
    return good;
}

}  // namespace

void add_simulate(CLI::App& program, int& exit_code) {
    auto options = std::make_shared<SimulateOptions>();
    CLI::App& command = *program.add_subcommand(
        "simulate", "Run clusters with faults in virtual time, by seed, and check the promises");
    command.set_help_flag("--help", "Show this and examples, and exit");
    command.add_option("--seeds", options->seeds, "FIRST..LAST, or one")
        ->check([](const std::string& text) {
            return range_of(text) ? std::string{}
                                  : "'" + text + "' is not FIRST..LAST, such as 1..100";
        })
        ->capture_default_str();
    command
        .add_option("--brokers", options->run.brokers, "Brokers (default: the seed says, 2 to 5)")
        ->check(CLI::Range(1, 100));
    command.add_option("--robots", options->run.robots, "Robots (default: the seed says, 2 to 7)")
        ->check(CLI::Range(1, 1000));
    command
        .add_option("--acks", options->acks,
                    "Peers that must hold an event before a client sees its effect, or all "
                    "(default: the seed says)")
        ->check([](const std::string& text) {
            const auto number = number_of(text);
            return text == "all" || (number && *number <= 99)
                       ? std::string{}
                       : "'" + text + "' is not 0 to 99 or all";
        });
    command
        .add_option("--fault", options->faults,
                    "A kind of fault; several times for several (default: all)")
        ->check(CLI::IsMember(words(sim::fault_names)))
        ->allow_extra_args(false);
    command
        .add_option("--faults-last-ms", options->faults_last_ms,
                    "Milliseconds of virtual time in which faults happen (default: 10000)")
        ->check(CLI::Range(1, 3'600'000));
    command.add_flag("--as-shipped", options->run.as_shipped,
                     "Profile, detector, elector and machines are the seed's, too");
    command.add_flag("--protected", options->run.is_protected,
                     "Robots and brokers seal their packets; no nonce may be used twice");
    command.add_flag("--dtls", options->run.speaks_dtls,
                     "They speak DTLS, some with a Connection ID; no number may be used twice");
    command.add_flag("--rights", options->run.has_rights,
                     "Robots with keys may not say and read everything, and their rights change");
    command.add_flag("--cells", options->run.has_cells,
                     "Brokers send once for many robots that listen to their cell");
    command.add_flag("--unable", options->run.are_some_unable,
                     "Half of the machines cannot take addresses of others");
    command.add_flag("--slewed", options->run.are_clocks_slewed,
                     "Time daemons slew the brokers' clocks by up to a twelfth");
    command
        .add_option("--profile", options->run.profile,
                    "Times of a profile (default: beacons every 10 ms, dead after 100)")
        ->check(CLI::IsMember(profile_names()));
    command.add_option("--elector", options->run.elector, "Elector (default: component)")
        ->check(CLI::IsMember(words(election::elector_names())));
    command.add_option("--detector", options->run.detector, "Failure detector (default: fixed)")
        ->check(CLI::IsMember(words(election::detector_names())));
    command.add_flag("--invariants", options->invariants,
                     "Also print in how many runs which invariant of the cluster broke");
    command.add_flag("--json", options->as_json, "Print the result as JSON");
    command.add_flag("--trace", options->trace, "Print all that happens");
    command.footer(simulate_examples);
    command.callback([options, &exit_code] {
        if (options->run.has_rights && !options->run.is_protected && !options->run.speaks_dtls) {
            throw CLI::ValidationError(
                "--rights: rights belong to keys; add --protected or --dtls");
        }
        exit_code = simulate(*options) ? 0 : 1;
    });
}

}  // namespace romano::experiments
