// One node of the comparison: publishes at a rate, hears, answers; and keeps the time of each
// message. The same code for every data path.

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include "bench/ros/node/data_path.h"
#include "bench/ros/samples.h"
#include "broker/net/clock.h"
#include "experiments/robots/stamp.h"

namespace romano::bench::ros {
namespace {

using namespace std::chrono_literals;
using experiments::Stamp;

constexpr const char* examples = R"(Examples:
  NODE --name a --address 127.0.0.1 --infrastructure 127.0.0.1 --publish t --rate 10
  NODE --name b --address 127.0.0.1 --infrastructure 127.0.0.1 --subscribe t --samples b.samples
romano_ros_bench starts nodes by itself. A node goes on until SIGTERM, and then writes its samples.
It prints `first` and the time, CLOCK_BOOTTIME in ns, when it hears its first message.)";

volatile std::sig_atomic_t stopped = 0;

struct Settings {
    NodePlan plan;
    bool best_effort = false;
    bool echo = false;
    double rate_per_s = 0;
    std::uint32_t octets = 32;
    std::uint32_t number = 0;
    std::string samples;
};

class Node {
public:
    explicit Node(const Settings& settings)
        : settings_(settings), payload_(settings.octets, 0x2A) {}

    void run() {
        const auto path =
            make_data_path(settings_.plan, [this](Bytes payload) { on_message(payload); });
        path_ = path.get();
        const auto period = settings_.rate_per_s > 0
                                ? std::chrono::duration_cast<Duration>(
                                      std::chrono::duration<double>(1 / settings_.rate_per_s))
                                : Duration{1h};
        Instant due = settings_.rate_per_s > 0 ? net::now() : net::now() + period;
        while (stopped == 0) {
            path->turn(std::min(due, net::now() + 50ms));
            if (net::now() < due) continue;
            publish();
            due += period;
        }
        if (!settings_.samples.empty()) write_samples(samples_, settings_.samples);
    }

private:
    void publish() {
        const Stamp stamp{
            .publisher = settings_.number, .sequence = sequence_++, .sent_at = net::now()};
        write_stamp(stamp, payload_);
        samples_.push_back(record(stamp, Instant{}));
        path_->publish(0, payload_);
    }
    void on_message(Bytes payload) {
        const Instant now = net::now();
        const auto stamp = experiments::read_stamp(payload);
        if (!stamp) return;
        if (!heard_) {
            std::printf("first %lld\n", static_cast<long long>(now.time_since_epoch().count()));
            std::fflush(stdout);
            heard_ = true;
        }
        if (settings_.echo) path_->publish(0, payload);
        samples_.push_back(record(*stamp, now));
    }
    static Sample record(const Stamp& stamp, Instant heard) {
        return {.publisher = stamp.publisher,
                .sequence = stamp.sequence,
                .sent_ns = stamp.sent_at.time_since_epoch().count(),
                .heard_ns = heard.time_since_epoch().count()};
    }

    const Settings& settings_;
    std::vector<std::uint8_t> payload_;
    DataPath* path_ = nullptr;
    std::uint32_t sequence_ = 0;
    bool heard_ = false;
    std::vector<Sample> samples_;
};

void read(CLI::App& app, Settings& to) {
    app.add_option("--name", to.plan.name, "Of this node")->required();
    app.add_option("--address", to.plan.address, "Of this machine")
        ->required()
        ->check(CLI::ValidIPV4);
    app.add_option("--infrastructure", to.plan.infrastructure,
                   "Address of the ROS 1 master, or of the broker")
        ->check(CLI::ValidIPV4);
    app.add_flag("--best-effort", to.best_effort, "What is lost is lost");
    app.add_option("--publish", to.plan.publishes, "Topic to publish on")->expected(1);
    app.add_option("--subscribe", to.plan.subscribes, "Topic to hear; may be repeated");
    app.add_flag("--echo", to.echo, "Publish what is heard, and nothing else");
    app.add_option("--rate", to.rate_per_s, "Messages a second")->check(CLI::Range(0.0, 1e6));
    app.add_option("--octets", to.octets, "Of a message")
        ->check(CLI::Range(std::size_t{Stamp::octets}, std::size_t{60'000}))
        ->capture_default_str();
    app.add_option("--number", to.number, "Of this publisher, in its messages");
    app.add_option("--samples", to.samples, "File for the time of each message");
    app.footer(examples);
}

int main_of_node(int argc, char** argv) {
    CLI::App app{"One node of the comparison with ROS (romano_ros_bench).", "NODE"};
    Settings settings;
    read(app, settings);
    try {
        app.parse(argc, argv);
        if ((settings.echo || settings.rate_per_s > 0) && settings.plan.publishes.empty()) {
            throw CLI::ValidationError("--publish", "is missing: --rate and --echo need a topic");
        }
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : 2;
    }
    settings.plan.reliable = !settings.best_effort;
    try {
        std::signal(SIGTERM, [](int) { stopped = 1; });
        Node(settings).run();
        return 0;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s: %s\n", settings.plan.name.c_str(), error.what());
        return 2;
    }
}

}  // namespace
}  // namespace romano::bench::ros

int main(int argc, char** argv) {
    return romano::bench::ros::main_of_node(argc, argv);
}
