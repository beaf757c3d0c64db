#include "broker/daemon/program.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <csignal>
#include <exception>
#include <iostream>
#include <memory>
#include <utility>

#include "broker/daemon/command_line.h"
#include "broker/daemon/hangups.h"
#include "broker/daemon/metrics_endpoint.h"
#include "broker/daemon/realtime.h"
#include "broker/daemon/refusal.h"
#include "broker/daemon/settings.h"
#include "broker/daemon/trace.h"
#include "broker/daemon/web_page.h"
#include "broker/net/service_manager.h"
#include "broker/net/turn_clock.h"

namespace romano::daemon {
namespace {

/// A signal came while the broker was still starting.
struct Interrupted {};

void run(const Settings& settings, const Program& program) {
    boost::asio::io_context io{1};  // one thread: no locks within Asio
    net::ServiceManager manager(io);
    std::unique_ptr<RunningBroker> broker;
    // Before the broker says that it serves, so that whoever waits for that may stop it.
    boost::asio::signal_set signals(io, SIGTERM, SIGINT);
    signals.async_wait([&](const auto& error, int) {
        if (error) return;
        if (!broker) throw Interrupted{};
        manager.ending();
        broker->leave();
    });
    const Hangups hangups(io, [&] {
        if (broker) broker->read_rights_again();
    });
    MetricsEndpoint metrics(io, settings);
    WebPage page(io, settings);
    broker = program.start(io, settings, [&](const Serving& serving) {
        const std::string where = words_for(serving);
        std::cout << "romano-broker " << settings.name << ": serving " << where << std::endl;
        manager.serving("serving " + where);
        page.show(serving.addresses);
    });
    metrics.tell_of(*broker);
    net::run_in_turns(io);
}

void run_lives(Settings settings, const Program& program) {
    program.prepare(settings);
    start_trace(settings.log_level);
    if (settings.realtime) become_realtime();  // before other threads begin: they inherit it
    for (;;) {
        try {
            return run(settings, program);
        } catch (const BeginsAgain& again) {
            settings.least_incarnation = again.least_incarnation;
        }
    }
}

}  // namespace

int run_program(int argc, const char* const* argv, const Program& program) {
    // Whoever reads our trace may go away; that is no reason to stop serving.
    std::signal(SIGPIPE, SIG_IGN);
    try {
        const auto read = read_command_line(argc, argv);
        if (const auto* information = std::get_if<Information>(&read)) {
            std::cout << information->text;
            return 0;
        }
        run_lives(check(std::get<SettingTexts>(read)), program);
        return 0;
    } catch (const Interrupted&) {
        return 0;
    } catch (const Refusal& refusal) {
        std::cerr << "romano-broker: " << refusal.what() << '\n';
        return 2;
    } catch (const std::exception& error) {
        std::cerr << "romano-broker: " << error.what() << '\n';
        return 1;
    }
}

}  // namespace romano::daemon
