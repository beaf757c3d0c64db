#include "experiments/cli/web.h"

#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "broker/net/clock.h"
#include "broker/net/endpoint_text.h"
#include "broker/net/socket_address.h"
#include "experiments/cli/broker_options.h"
#include "experiments/cli/denial.h"
#include "experiments/cli/interrupt.h"
#include "experiments/fleet/fleet_picture.h"
#include "experiments/web/fleet_watch.h"
#include "experiments/web/web_api.h"
#include "experiments/web/web_server.h"

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;
using boost::asio::ip::tcp;

constexpr const char* web_examples = R"(Examples:
  romano web                                  (then open http://127.0.0.1:8080/)
  romano web -h 127.0.0.2 --ask 1             (asks robots each second where they are)
  romano web --topics 'robots/#' --listen 127.0.0.1:9000
  curl -s http://127.0.0.1:8080/api/state | jq '.robots[] | {robot, home}'
  curl -X POST -H 'Content-Type: application/json' http://127.0.0.1:8080/api/stop

Whoever reaches the page can steer the robots, so it listens on this machine alone. From
elsewhere, with ssh: ssh -L 8080:127.0.0.1:8080 MACHINE
)";

struct WebOptions {
    BrokerOptions broker;
    std::string listen = "127.0.0.1:8080";
    bool lets_everybody_steer = false;
    std::vector<std::string> filters = {"#"};
    double ask_s = 0;
};

tcp::endpoint address_in(const WebOptions& options) {
    const auto endpoint = net::parse_endpoint(options.listen);
    if (!endpoint) {
        throw CommandError("--listen `" + options.listen +
                           "`: must be an IP address and a port, for example 127.0.0.1:8080");
    }
    const net::SocketAddress address = net::to_socket_address(*endpoint);
    tcp::endpoint out;
    out.resize(address.size);
    std::memcpy(out.data(), &address.any, address.size);
    if (!out.address().is_loopback() && !options.lets_everybody_steer) {
        throw CommandError("--listen `" + options.listen +
                           "`: other machines reach this address, and whoever reaches the page can "
                           "steer all robots; allowed is an address of this machine alone such as "
                           "127.0.0.1:8080, or any with --let-everybody-steer");
    }
    return out;
}

/// What browsers on this machine and others may call it.
std::vector<std::string> names_of_this_machine() {
    char host[256] = {};
    (void)::gethostname(host, sizeof host - 1);
    return {"localhost", host, std::string{host} + ".local"};
}

void serve(const WebOptions& options) {
    const tcp::endpoint address = address_in(options);
    boost::asio::io_context io{1};
    const Interrupt interrupt{io};
    FleetPicture picture{net::unix_time_at_zero(), options.broker.where()};
    FleetWatch watch{io,
                     {.broker = resolve_broker(io, options.broker.host, options.broker.port),
                      .client_id = options.broker.id_or("romano-web"),
                      .timing = options.broker.timing(),
                      .keep_alive = client::KeepAlive{options.broker.keep_alive_s},
                      .filters = options.filters,
                      .ask_every = std::chrono::duration_cast<Duration>(
                          std::chrono::duration<double>{options.ask_s})},
                     picture};
    WebApi api{picture, watch, names_of_this_machine()};
    WebServer server{io, picture, api};
    if (const auto error = server.open(address)) {
        throw CommandError("--listen `" + options.listen + "`: " + error.message());
    }
    bool is_told = false;
    while (!interrupt.has_come()) {
        io.run_one_for(100ms);
        if (watch.has_begun()) {
            if (!is_told) {
                std::printf("the fleet is shown at http://%s/\n",
                            (server.address().address().is_v6()
                                 ? '[' + server.address().address().to_string() + ']'
                                 : server.address().address().to_string())
                                .append(":" + std::to_string(server.address().port()))
                                .c_str());
                std::fflush(stdout);
                is_told = true;
            }
        } else if (watch.has_failed() || watch.denial()) {
            throw CommandError(why_not(options.broker, watch.denial(), watch.was_refused()));
        }
    }
    watch.leave();
}

}  // namespace

void add_web(CLI::App& program, int& exit_code) {
    auto options = std::make_shared<WebOptions>();
    CLI::App& command = *program.add_subcommand(
        "web", "Show the fleet as a page in a browser, and let people steer it there");
    options->broker.add_to(command);
    command.add_option("--listen", options->listen, "Where the page is served")
        ->type_name("ADDR:PORT")
        ->capture_default_str();
    command.add_flag("--let-everybody-steer", options->lets_everybody_steer,
                     "Serve other machines too: whoever reaches the page can steer all robots");
    command
        .add_option("--topics", options->filters,
                    "What is listened to for rates, places and messages (repeatable)")
        ->type_name("FILTER")
        ->capture_default_str();
    command
        .add_option("--ask", options->ask_s,
                    "Ask each robot where it is, if it has not said so for so long; 0: never")
        ->type_name("SECONDS")
        ->check(CLI::Range(0.0, 3600.0))
        ->capture_default_str();
    command.footer(web_examples);
    command.callback([options, &exit_code] {
        serve(*options);
        exit_code = 0;
    });
}

}  // namespace romano::experiments
