// romano-broker-robot: a robot that is a broker too, one process on one thread. The robot's own
// client is a client as any other of the broker that it carries.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <csignal>
#include <cstdio>
#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>

#include "broker/daemon/command_line.h"
#include "broker/daemon/hangups.h"
#include "broker/daemon/lone_broker.h"
#include "broker/daemon/metrics_endpoint.h"
#include "broker/daemon/refusal.h"
#include "broker/daemon/running_broker.h"
#include "broker/daemon/settings.h"
#include "broker/daemon/trace.h"
#include "broker/daemon/web_page.h"
#include "broker/net/service_manager.h"
#include "broker/net/socket_address.h"
#include "firmware/posix/simulated_robot.h"
#include "firmware/robot/address.h"
#include "overlay/daemon/cluster_broker.h"
#include "romano/cli/real_number.h"

namespace {

using namespace romano;

constexpr const char* examples = R"(Examples:
  romano-broker-robot --id abcd1234 --allow-plain --listen 192.168.1.5:1883 --domain 7
      a robot that is one broker of the cluster on DDS domain 7
  romano-broker-robot --id 00000002 --listen 127.0.0.2:1883 --domain 7 --interface lo --telemetry pose

All options of romano-broker are options here too (romano-broker --help). With --cell-group the robot
listens to the cell, as its broker's other listeners do.
Exit code: 0 after SIGTERM or SIGINT, 2 when a setting is not possible.)";

struct Settings {
    std::string id;
    std::string telemetry;
    double every_s = 1;
    daemon::Settings broker;
};

firmware::SimulatedRobotOptions robot_options(const Settings& settings) {
    const auto id = message::RomanoId::parse(settings.id);
    if (!id) {
        throw daemon::Refusal("--id '" + settings.id +
                              "': must be 8 lower-case hexadecimal digits, for example abcd1234");
    }
    if (settings.broker.listen.front().packets != Endpoint::Packets::plain) {
        throw daemon::Refusal(
            "--listen: the robot in this process speaks plain; give it a plain address first, for "
            "example 127.0.0.1:1884");
    }
    if (settings.broker.listen.front().port == 0) {
        throw daemon::Refusal("--listen: the robot must know its broker's port; it cannot be 0");
    }
    firmware::SimulatedRobotOptions options;
    options.robot.node.id = *id;
    options.robot.broker = net::as_reached_here(settings.broker.listen.front());
    options.robot.timing.t_retry = std::chrono::seconds{1};
    const std::optional<Endpoint>& group = settings.broker.cell_group;
    if (group && group->family == options.robot.broker.family) {
        options.local = firmware::address_of(options.robot.broker);
        options.local.port = 0;
        options.cell_group = firmware::address_of(*group);
        options.robot.node.listens_to_cell = true;
    }
    options.telemetry_topic = settings.telemetry;
    options.telemetry_every =
        std::chrono::duration_cast<Duration>(std::chrono::duration<double>{settings.every_s});
    firmware::check_topics(options);
    return options;
}

std::unique_ptr<daemon::RunningBroker> start_broker(boost::asio::io_context& io,
                                                    const daemon::Settings& settings,
                                                    daemon::OnServing on_serving) {
    if (!settings.cluster) return std::make_unique<daemon::LoneBroker>(io, settings, on_serving);
    return std::make_unique<daemon::ClusterBroker>(io, settings, std::move(on_serving));
}

void run(const Settings& settings) {
    const firmware::SimulatedRobotOptions options = robot_options(settings);
    boost::asio::io_context io{1};
    daemon::start_trace(settings.broker.log_level);
    net::ServiceManager manager(io);
    std::unique_ptr<firmware::SimulatedRobot> robot;
    std::unique_ptr<daemon::RunningBroker> broker;
    boost::asio::signal_set signals(io, SIGTERM, SIGINT);
    signals.async_wait([&](const auto& error, int) {
        if (error || !broker) return;
        manager.ending();
        if (!robot) return broker->leave();
        robot->leave([&] { broker->leave(); });
    });
    const daemon::Hangups hangups(io, [&] {
        if (broker) broker->read_rights_again();
    });
    daemon::MetricsEndpoint metrics(io, settings.broker);
    daemon::WebPage page(io, settings.broker);
    broker = start_broker(io, settings.broker, [&](const daemon::Serving& serving) {
        const std::string where = daemon::words_for(serving);
        std::printf("romano-broker-robot %s: serving %s\n", settings.broker.name.c_str(),
                    where.c_str());
        std::fflush(stdout);
        manager.serving("serving " + where);
        page.show(serving.addresses);
        robot = std::make_unique<firmware::SimulatedRobot>(
            io, options, [](const message::RomanoId& id, const std::string& what) {
                std::printf("%s %s\n", std::string{id.text()}.c_str(), what.c_str());
                std::fflush(stdout);
            });
    });
    metrics.tell_of(*broker);
    net::run_in_turns(io);
}

Settings read(int argc, char** argv) {
    CLI::App app{"A robot that is a ROMANO broker too.", "romano-broker-robot"};
    app.footer(examples);
    app.allow_extras();
    Settings settings;
    app.add_option("--id", settings.id, "The robot's ROMANO id")->required();
    app.add_option("--telemetry", settings.telemetry, "Publish the own location on this topic")
        ->type_name("TOPIC");
    app.add_option("--every", settings.every_s, "Seconds between two locations")
        ->needs("--telemetry")
        ->check(real_number(0.001, 3600))
        ->capture_default_str();
    app.parse(argc, argv);
    const std::vector<std::string> rest = app.remaining();
    std::vector<const char*> of_broker{argv[0]};
    for (const std::string& word : rest) of_broker.push_back(word.c_str());
    const auto texts =
        daemon::read_command_line(static_cast<int>(of_broker.size()), of_broker.data());
    settings.broker = daemon::check(std::get<daemon::SettingTexts>(texts));
    return settings;
}

}  // namespace

int main(int argc, char** argv) {
    std::signal(SIGPIPE, SIG_IGN);
    try {
        run(read(argc, argv));
        return 0;
    } catch (const CLI::CallForHelp&) {
        std::printf(
            "A robot that is a ROMANO broker too, one process.\n\n"
            "  --id ID            the robot's ROMANO id (8 lower-case hexadecimal digits)\n"
            "  --telemetry TOPIC  publish the own location on this topic\n"
            "  --every SECONDS    between two locations (1)\n\n%s\n",
            examples);
        return 0;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "romano-broker-robot: %s\n", error.what());
        return 2;
    }
}
