// romano_ros_bench: the same work on ROS 1, on ROS 2's data path, on this broker and on mosquitto.

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <set>
#include <stdexcept>
#include <string>

#include "bench/ros/neighbour_room.h"
#include "bench/ros/ros_report.h"
#include "bench/ros/scratch.h"
#include "bench/ros/tasks.h"
#include "bench/ros/world.h"
#include "experiments/process/separate_runs.h"
#include "experiments/report/section.h"
#include "experiments/sweep/build_info.h"
#include "experiments/sweep/machine.h"
#include "experiments/sweep/progress_bar.h"

namespace {

using namespace romano::bench::ros;
namespace experiments = romano::experiments;
namespace fs = std::filesystem;

constexpr const char* examples = R"(Examples:
  romano_ros_bench                                 (all; as root)
  romano_ros_bench --quick                         (a look at all parts in a few minutes)
  romano_ros_bench --parts delay,idle --contestants ros2_cyclone,romano_3 --output results/two
Parts: delay (one to one, 10 to 1,000 messages/s), fan_out (1 to 50 subscribers), telemetry (20 robots),
start (until the first message), idle (a node that says nothing), deaths (of master, broker, subscriber).
Contestants: ros1, ros2_cyclone, ros2_fastdds, romano_1, romano_3, romano_5, mosquitto; each reliable, and
where it is of interest best effort. All take turns in each piece of work. Begun again, it goes on where it
was interrupted. The folder then holds report.html, results.csv and results.json, each table as CSV, and
each figure as SVG where gnuplot is.
Exit code: 0; 1 when a run failed; 2 when an argument is wrong or nothing can be measured here.)";

struct Settings {
    Plan plan;
    std::vector<std::string> contestants;
    fs::path output = "results/ros";
    bool fresh = false;
};

struct WrongArgument : std::runtime_error {
    using std::runtime_error::runtime_error;
};

std::vector<std::string> names_of_contestants() {
    std::vector<std::string> names;
    for (const Contestant& one : all_contestants()) {
        if (one.reliable) names.push_back(one.name);
    }
    return names;
}

void read(CLI::App& app, Settings& to) {
    to.plan.parts = all_parts();
    to.contestants = names_of_contestants();
    app.add_flag("--quick", to.plan.quick, "Short and small: a look, no figures to quote");
    app.add_option("--parts", to.plan.parts, "Of the work, one or several")
        ->delimiter(',')
        ->check(CLI::IsMember(all_parts()));
    app.add_option("--contestants", to.contestants, "One or several")
        ->delimiter(',')
        ->check(CLI::IsMember(names_of_contestants()));
    app.add_option("--output", to.output, "Folder of runs, tables, figures and report")
        ->capture_default_str();
    app.add_flag("--fresh", to.fresh, "Forget the runs that stand in --output");
    app.footer(examples);
}

/// Who is asked for by name must be here; of the others those that are.
void choose_contestants(Settings& settings, bool by_name) {
    std::set<std::string> told;
    for (const Contestant& one : all_contestants()) {
        if (std::ranges::find(settings.contestants, one.name) == settings.contestants.end()) {
            continue;
        }
        const std::string missing = what_is_missing(one, settings.plan.programs);
        if (missing.empty()) {
            settings.plan.contestants.push_back(one);
        } else if (by_name) {
            throw WrongArgument("--contestants " + one.name + ": " + missing);
        } else if (told.insert(one.name).second) {
            std::fprintf(stderr, "romano_ros_bench: %s is left out: %s\n", one.name.c_str(),
                         missing.c_str());
        }
    }
    if (settings.plan.contestants.empty()) {
        throw WrongArgument("there is nobody to compare: build the node programs (bench/ros/run)");
    }
}

std::string name_of(const Task& task, const Contestant& contestant) {
    return task.name + "-" + contestant.full_name();
}

void write(const fs::path& file, const std::string& text) {
    std::ofstream out(file);
    if (!(out << text).flush()) throw std::runtime_error("cannot write `" + file.string() + "`");
}

std::string about(const Plan& plan) {
    const auto machine = experiments::this_machine();
    const auto build = experiments::build_info();
    return "Measured on " + machine.cpu + ", " + std::to_string(machine.cores) + " cores, " +
           machine.system + ", " + machine.kernel + "; commit " + build.commit + ", " +
           build.compiler + ", " + (build.type.empty() ? "no build type" : build.type) +
           (plan.quick ? "; --quick, so no figures to quote" : "") + ". ";
}

int run(Settings& settings, bool by_name) {
    Plan& plan = settings.plan;
    if (::geteuid() != 0) throw WrongArgument("network namespaces need root: run it as root");
    plan.programs = fs::read_symlink("/proc/self/exe").parent_path();
    const Scratch scratch(fs::temp_directory_path() /
                          ("romano-ros-bench-" + std::to_string(::getpid())));
    plan.scratch = scratch.folder();
    choose_contestants(settings, by_name);
    const auto folder = settings.output / (plan.quick ? "quick_runs" : "runs");
    std::error_code failed;
    if (settings.fresh) fs::remove_all(folder, failed);
    fs::create_directories(folder, failed);
    if (failed) {
        throw WrongArgument("--output " + settings.output.string() +
                            ": cannot be written; it must be a folder");
    }
    heed_interrupts();
    const NeighbourRoom room;
    const auto tasks = tasks_of(plan);
    std::vector<std::vector<experiments::SeparateRun>> runs;
    std::size_t total = 0;
    std::size_t done = 0;
    for (const Task& task : tasks) {
        auto& turn = runs.emplace_back();
        for (const Contestant& one : plan.contestants) {
            if (!takes_part(one, task)) continue;
            turn.push_back({name_of(task, one),
                            [&task, &one, &plan] { return to_csv(task.work(one, plan)); }});
            ++total;
            if (is_done(turn.back(), folder)) ++done;
        }
    }
    experiments::ProgressBar bar{stderr, total, done};
    bar.show(0, "begins");
    for (std::size_t i = 0; i < tasks.size(); ++i) {
        const auto at_once = static_cast<unsigned>(tasks[i].all_at_once ? runs[i].size() : 1);
        do_runs(runs[i], folder, at_once,
                [&](const experiments::SeparateRun& one) { bar.finish_cell(one.name); });
    }
    bar.erase();
    Results results;
    for (const Task& task : tasks) {
        for (const Contestant& one : plan.contestants) {
            if (!takes_part(one, task)) continue;
            results.add(one.full_name(), task.name,
                        figures_in(experiments::outcome_of(name_of(task, one), folder)));
        }
    }
    auto sections = sections_of(plan, results);
    sections.front().words = about(plan) + sections.front().words;
    write(settings.output / "results.csv", to_csv(results));
    write(settings.output / "results.json", to_json(results));
    write_report({"ROMANO and ROS", "The same work on ROS 1, ROS 2's data path, ROMANO and MQTT"},
                 sections, settings.output);
    std::printf("%s%s\n", experiments::to_text(sections).c_str(),
                (settings.output / "report.html").c_str());
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app{
        "Compares this broker with ROS 1, with ROS 2's data path (Cyclone DDS, Fast DDS) and with "
        "mosquitto: the same work, side by side, on network namespaces.",
        "romano_ros_bench"};
    Settings settings;
    read(app, settings);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : 2;
    }
    try {
        return run(settings, app.count("--contestants") > 0);
    } catch (const WrongArgument& error) {
        std::fprintf(stderr, "romano_ros_bench: %s\n", error.what());
        return 2;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "romano_ros_bench: %s\n", error.what());
        return 1;
    }
}
