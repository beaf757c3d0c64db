// romano-broker: reads its settings, runs one broker until SIGTERM or SIGINT.

#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <csignal>
#include <exception>
#include <iostream>
#include <memory>
#include <utility>

#include "broker/daemon/command_line.h"
#include "broker/daemon/realtime.h"
#include "broker/daemon/refusal.h"
#include "broker/daemon/running_broker.h"
#include "broker/daemon/settings.h"
#include "broker/daemon/trace.h"

namespace {

using namespace romano::daemon;

/// A signal came while the broker was still starting.
struct Interrupted {};

void run(const Settings& settings) {
    boost::asio::io_context io{1};  // one thread: no locks within Asio
    start_trace(settings.log_level);
    if (settings.realtime) become_realtime();  // before other threads begin: they inherit it
    std::unique_ptr<RunningBroker> broker;
    // Before the broker says that it serves, so that whoever waits for that may stop it.
    boost::asio::signal_set signals(io, SIGTERM, SIGINT);
    signals.async_wait([&](const auto& error, int) {
        if (error) return;
        if (!broker) throw Interrupted{};
        broker->leave();
    });
    broker = start_broker(io, settings, [&](const std::string& where) {
        std::cout << "romano-broker " << settings.name << ": serving " << where << std::endl;
    });
    io.run();
}

}  // namespace

int main(int argc, char** argv) {
    // Whoever reads our trace may go away; that is no reason to stop serving.
    std::signal(SIGPIPE, SIG_IGN);
    try {
        const auto read = read_command_line(argc, argv);
        if (const auto* information = std::get_if<Information>(&read)) {
            std::cout << information->text;
            return 0;
        }
        run(check(std::get<SettingTexts>(read)));
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
