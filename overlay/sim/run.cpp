#include "overlay/sim/run.h"

#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstring>
#include <memory>

#include "election/elector.h"
#include "election/failure_detector.h"
#include "election/profile.h"
#include "overlay/sim/cluster_world.h"
#include "overlay/sim/seed.h"
#include "overlay/sim/settlement.h"

namespace romano::sim {

using namespace std::chrono_literals;
using mqttsn::Qos;

namespace {

constexpr Duration publish_on_after_faults = 1s;
constexpr std::size_t most_random_robots = 7;
constexpr std::uint32_t recorded_ppm = 300'000;          // of protected worlds: by a stranger
constexpr std::int64_t slewed_ppm_max = 1'000'000 / 12;  // by a time daemon
constexpr Duration played_back_within = 3s;
constexpr Duration deliveries_within = 20s;
constexpr std::string_view topics[] = {"pose", "map/a", "map/b", "cmd"};

template <typename Choices>
auto one_of(Random& random, const Choices& choices) {
    return choices[random.below(static_cast<std::uint32_t>(std::size(choices)))];
}

/// What ships: each profile with each detector and elector, on machines of several kinds.
void choose_as_shipped(std::uint64_t seed, ClusterWorldOptions& options) {
    static constexpr std::int64_t drifts[] = {50, 100, 1'000};
    static constexpr Duration turns[] = {1ms, 1ms, 3ms, 8ms};
    Random random(seed_of(seed, "as shipped"));
    options.profile = one_of(random, election::profiles).name;
    options.cluster.elector = one_of(random, election::elector_names());
    options.cluster.detector = one_of(random, election::detector_names());
    options.machine = {.drift_ppm_max = one_of(random, drifts), .turn = one_of(random, turns)};
}

void take_times_of(const election::Profile& profile, ClusterWorldOptions& options) {
    options.profile = profile.name;
    options.cluster.beacon_every = profile.beacon_every;
    options.cluster.detection_timeout = profile.detection_timeout;
    options.cluster.phi_threshold = profile.phi_threshold;
    const auto slower = std::max<std::int64_t>(1, profile.detection_timeout / 100ms);
    options.t_retry *= slower;
    options.t_wait *= slower;
}

ClusterWorldOptions world_options(std::uint64_t seed, const RunOptions& run) {
    Random random(seed_of(seed, "setting"));
    Random turns(seed_of(seed, "turns"));
    ClusterWorldOptions options;
    options.seed = seed;
    options.brokers = 2 + random.below(4);
    if (run.brokers > 0) options.brokers = run.brokers;
    options.cluster.elector = "component";
    options.cluster.detector = "fixed";
    static constexpr std::uint32_t some_acks[] = {1, 1, 2, cluster::all_peers};
    options.cluster.acks = one_of(random, some_acks);
    if (run.acks) options.cluster.acks = *run.acks;
    options.peers.quality.delay_max = random.between(100us, 3ms);
    static constexpr std::size_t some_events[] = {256, 256, 2, 1};
    options.cluster.events_per_turn = one_of(turns, some_events);
    options.cluster.sessions_per_turn = one_of(turns, some_events);
    if (run.as_shipped) choose_as_shipped(seed, options);
    if (run.are_clocks_slewed) options.machine.drift_ppm_max = slewed_ppm_max;
    options.is_protected = run.is_protected;
    options.speaks_dtls = run.speaks_dtls;
    options.has_cells = run.has_cells;
    options.are_some_unable = run.are_some_unable;
    if (run.has_rights) options.topics_with_rights.assign(std::begin(topics), std::end(topics));
    options.robots = std::max(run.robots, most_random_robots);
    if (!run.elector.empty()) options.cluster.elector = run.elector;
    if (!run.detector.empty()) options.cluster.detector = run.detector;
    if (!run.profile.empty()) options.profile = run.profile;
    const auto& profiles = election::profiles;
    const auto profile = std::ranges::find(profiles, options.profile, &election::Profile::name);
    if (profile != profiles.end()) take_times_of(*profile, options);
    return options;
}

/// In all the time that a fault lasts no robot is lost for its silence, and about as much is said.
void adapt_to_scale(RobotOptions& robot, const ClusterWorld& world) {
    robot.publish_every_min = world.in_scale(robot.publish_every_min);
    robot.publish_every_max = world.in_scale(robot.publish_every_max);
    robot.timing.t_retry = world.in_scale_at_least(robot.timing.t_retry);
    robot.timing.t_wait = world.in_scale_at_least(robot.timing.t_wait);
    robot.keep_alive =
        std::chrono::duration_cast<std::chrono::seconds>(world.in_scale_at_least(robot.keep_alive));
}

/// Robots of every kind of traffic: who publishes where, who listens to what, at which QoS.
void add_robots(ClusterWorld& world, std::uint64_t seed, const RunOptions& run) {
    static constexpr const char* filters[] = {"pose", "map/+", "map/a", "cmd", "#", "will/+"};
    static constexpr std::chrono::seconds keep_alives[] = {6s, 8s, 60s};
    static constexpr Qos some_qos[] = {Qos::at_least_once, Qos::exactly_once, Qos::exactly_once};
    Random random(seed_of(seed, "robots"));
    Random addresses(seed_of(seed, "addresses"));
    Random cells(seed_of(seed, "cells"));
    const bool may_share = std::ranges::count(run.faults, Fault::share) > 0;
    const std::size_t count = run.robots > 0 ? run.robots : 2 + random.below(6);
    for (std::size_t i = 0; i < count; ++i) {
        RobotOptions robot;
        robot.broker =
            World::service_address(random.below(static_cast<std::uint32_t>(world.broker_count())));
        robot.clean_session = random.below(2) == 0;
        for (std::uint32_t n = random.below(3); n > 0; --n) {
            robot.topics.emplace_back(one_of(random, topics));
        }
        // One filter each, or several that may overlap.
        for (std::uint32_t n = 1 + random.below(2); n > 0; --n) {
            const std::string filter = one_of(random, filters);
            if (std::ranges::any_of(robot.subscriptions,
                                    [&](const auto& s) { return s.filter == filter; })) {
                continue;
            }
            robot.subscriptions.push_back({filter, one_of(random, some_qos)});
        }
        robot.qos = {Qos::at_least_once, Qos::exactly_once};
        if (random.below(4) == 0) robot.qos.push_back(Qos::at_most_once);
        robot.retain_ppm = random.below(3) == 0 ? 100'000 : 0;
        robot.keep_alive = one_of(random, keep_alives);
        if (robot.keep_alive < 60s && random.below(2) == 0) {
            robot.will_topic = "will/" + std::to_string(i);
        }
        robot.publish_every_min = random.between(5ms, 50ms);
        robot.publish_every_max = robot.publish_every_min * 4;
        if (may_share && i % 2 == 1 && addresses.below(2) == 0) {
            const RobotOptions& other = world.robot(i - 1).options();
            if (other.broker != robot.broker) robot.address = other.address;
        }
        adapt_to_scale(robot, world);
        if (run.is_protected) robot.sealed = &world.sealed();
        if (run.speaks_dtls) robot.dtls = &world.dtls();
        robot.has_id = run.speaks_dtls && i % 2 == 0;
        if (run.has_cells) {
            if (cells.below(4) != 0) robot.cell_group = World::cell_group();
            robot.subscriptions.push_back({"common", one_of(cells, some_qos)});
            robot.topics.push_back("common");
            robot.topics.push_back("common");
        }
        world.add_robot(std::move(robot));
    }
}

class Run {
public:
    Run(std::uint64_t seed, const RunOptions& options)
        : options_(options), world_(world_options(seed, options)) {
        if (options.trace) world_.trace().listen(options.trace);
        if (options.is_protected || options.speaks_dtls) {
            world_.clients().record(recorded_ppm, played_back_within);
        }
        if (options.speaks_dtls) world_.clients().bend_recorded();
        judgement_.rights = world_.rights();
        add_robots(world_, seed, options);
    }

    RunResult carry_out() {
        start();
        if (result_.is_good()) suffer();
        if (result_.is_good()) recover();
        fill_in_result();
        return std::move(result_);
    }

private:
    void start() {
        world_.start_brokers();
        for (std::size_t i = 0; i < world_.robot_count(); ++i) world_.robot(i).start();
        expect_idle("at the start");
        for (std::size_t i = 0; i < world_.robot_count(); ++i) world_.robot(i).begin_publishing();
    }

    void suffer() {
        RandomFaultsOptions faults;
        if (!options_.faults.empty()) faults.kinds = options_.faults;
        faults.lost_at_once = world_.options().cluster.acks;  // as many as P2 allows
        storm_.emplace(world_, faults, world_.seed());
        storm_->begin();
        change_rights_in_the_middle();
        world_.run_for(world_.in_scale(options_.faults_last));
        storm_->end();
        result_.faults = storm_->counts();
        judgement_.parted = storm_->parted();
        judge_safety(world_.ledger(), judgement_, result_.violations);
    }

    void change_rights_in_the_middle() {
        if (world_.rights() == nullptr) return;
        Random random(seed_of(world_.seed(), "when rights change"));
        const Duration all = world_.in_scale(options_.faults_last);
        world_.events().after(random.between(all / 4, all * 3 / 4),
                              [this] { world_.change_rights(); });
    }

    void recover() {
        world_.run_for(world_.in_scale_at_least(publish_on_after_faults));
        for (std::size_t i = 0; i < world_.robot_count(); ++i) world_.robot(i).end_publishing();
        expect_idle("after the faults");
        if (!result_.is_good()) return;
        for (Span& span : judgement_.parted) span.until = std::min(span.until, world_.now());
        (void)world_.run_until(
            [this] {
                Violations missing;
                judge_completeness(world_.ledger(), judgement_, missing);
                judge_settlement(world_, missing);
                return missing.empty();
            },
            by_slowest_clock(world_.in_scale_at_least(deliveries_within)), world_.in_scale(200ms));
        judge_safety(world_.ledger(), judgement_, result_.violations);
        judge_completeness(world_.ledger(), judgement_, result_.violations);
        judge_settlement(world_, result_.violations);
    }

    /// By its own clock a broker waits for a silent robot before it publishes the will.
    [[nodiscard]] Duration by_slowest_clock(Duration time) const {
        return options_.are_clocks_slewed ? time * (1'000'000 + slewed_ppm_max) / 1'000'000 : time;
    }

    /// Agreement, and no robot waits for a broker.
    void expect_idle(const std::string& when) {
        const bool is_quiet = world_.run_until(
            [this] { return world_.robots_are_idle() && !disagreement(world_); },
            world_.in_scale_at_least(options_.settles_within), world_.in_scale(10ms));
        if (is_quiet) return;
        if (const auto reason = disagreement(world_)) {
            result_.violations.push_back({Promise::one_leader, *reason + ", still, " + when});
        }
        for (std::size_t i = 0; i < world_.robot_count(); ++i) {
            const Robot& robot = world_.robot(i);
            if (!robot.is_on() || robot.is_idle()) continue;
            result_.violations.push_back(
                {Promise::liveness, robot.name() + " still waits for its broker " + when});
        }
    }

    void fill_in_result() {
        for (const Violation& violation : world_.violations()) {
            result_.violations.push_back(violation);
        }
        if (const std::uint64_t repeated = world_.sealed().repeated(); repeated > 0) {
            result_.violations.push_back(
                {Promise::sealed_once, std::to_string(repeated) + " nonces were used twice"});
        }
        for (const std::string& wrong : world_.dtls().wrongs()) {
            result_.violations.push_back({Promise::sealed_once, wrong});
        }
        result_.sealed = world_.sealed().count() + world_.dtls().count();
        result_.moved = world_.dtls().moved();
        result_.sent_to_cells = world_.clients().sent_to_groups();
        result_.breaches = world_.breaches();
        result_.seed = world_.seed();
        result_.trace_hash = world_.trace().hash();
        result_.virtual_time = world_.now().time_since_epoch();
        result_.received = world_.ledger().receptions.size();
        result_.acknowledged = static_cast<std::uint64_t>(
            std::ranges::count_if(world_.ledger().sent, [](const auto& entry) {
                return entry.second.acknowledged && entry.second.qos != Qos::at_most_once;
            }));
        const auto acks = world_.options().cluster.acks;
        result_.setting = std::to_string(world_.broker_count()) + " brokers, " +
                          std::to_string(world_.robot_count()) + " robots, " + world_.elector() +
                          ", acks " + (acks == cluster::all_peers ? "all" : std::to_string(acks));
        const cluster::ClusterOptions& cluster = world_.options().cluster;
        result_.profile = world_.options().profile;
        result_.detector = cluster.detector;
        result_.elector = cluster.elector;
        if (!result_.profile.empty()) result_.setting += ", " + result_.profile;
        if (cluster.detector != "fixed") result_.setting += ", " + cluster.detector;
    }

    RunOptions options_;
    ClusterWorld world_;
    Judgement judgement_;
    std::optional<RandomFaults> storm_;  // its last timers refer to it
    RunResult result_;
};

// What a core's failed assertion leaves behind: who was running.
char epitaph[256];

void on_abort(int) {
    (void)!write(STDERR_FILENO, epitaph, std::strlen(epitaph));
}

/// While it lives, an abort says which seed it was.
class Epitaph {
public:
    Epitaph(std::uint64_t seed, const RunOptions& options) {
        const std::string text = "seed " + std::to_string(seed) +
                                 " aborted; replay: " + replay_command(seed, options) + '\n';
        std::strncpy(epitaph, text.c_str(), sizeof epitaph - 1);
        previous_ = std::signal(SIGABRT, on_abort);
    }
    ~Epitaph() { (void)std::signal(SIGABRT, previous_); }
    Epitaph(const Epitaph&) = delete;
    Epitaph& operator=(const Epitaph&) = delete;

private:
    void (*previous_)(int) = nullptr;
};

}  // namespace

RunResult run_seed(std::uint64_t seed, const RunOptions& options) {
    const Epitaph epitaph_of_this(seed, options);
    return Run(seed, options).carry_out();
}

bool run_seeds(const SeedRange& seeds, const RunOptions& options,
               const std::function<void(const RunResult&)>& report) {
    bool all_good = true;
    for (std::uint64_t seed = seeds.first; seed <= seeds.last; ++seed) {
        const RunResult result = run_seed(seed, options);
        all_good = all_good && result.is_good();
        report(result);
    }
    return all_good;
}

std::string replay_command(std::uint64_t seed, const RunOptions& options) {
    std::string command = "romano simulate --seeds " + std::to_string(seed);
    if (options.as_shipped) command += " --as-shipped";
    if (options.is_protected) command += " --protected";
    if (options.speaks_dtls) command += " --dtls";
    if (options.has_rights) command += " --rights";
    if (options.has_cells) command += " --cells";
    if (options.are_some_unable) command += " --unable";
    if (options.are_clocks_slewed) command += " --slewed";
    if (!options.profile.empty()) command += " --profile " + options.profile;
    if (options.brokers > 0) command += " --brokers " + std::to_string(options.brokers);
    if (options.robots > 0) command += " --robots " + std::to_string(options.robots);
    if (!options.elector.empty()) command += " --elector " + options.elector;
    if (!options.detector.empty()) command += " --detector " + options.detector;
    if (options.acks) {
        command += " --acks ";
        command += *options.acks == cluster::all_peers ? "all" : std::to_string(*options.acks);
    }
    for (const Fault fault : options.faults) {
        command += " --fault ";
        command += name_of(fault);
    }
    if (options.faults_last != RunOptions{}.faults_last) {
        using std::chrono::duration_cast;
        const auto last = duration_cast<std::chrono::milliseconds>(options.faults_last);
        command += " --faults-last-ms " + std::to_string(last.count());
    }
    return command + " --trace";
}

}  // namespace romano::sim
