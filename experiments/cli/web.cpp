#include "experiments/cli/web.h"

#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "broker/https/gate.h"
#include "broker/net/clock.h"
#include "broker/net/endpoint_text.h"
#include "broker/net/socket_address.h"
#include "experiments/cli/broker_options.h"
#include "experiments/cli/denial.h"
#include "experiments/cli/interrupt.h"
#include "experiments/fleet/fleet_picture.h"
#include "experiments/mcap/reader.h"
#include "experiments/recording/playback.h"
#include "experiments/recording/recording_file.h"
#include "experiments/web/fleet_watch.h"
#include "experiments/web/web_api.h"
#include "experiments/web/web_server.h"
#include "romano/cli/real_number.h"
#include "romano/keys/key_error.h"

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;

constexpr const char* web_examples = R"(Examples:
  romano web                                  (then open http://127.0.0.1:8080/)
  romano web -h 127.0.0.2 --ask 1             (asks robots each second where they are)
  romano web --topics 'robots/#' --listen 127.0.0.1:9000
  romano web --key anna.key -h 192.168.1.5    (of brokers with protected addresses)
  romano web --recording tuesday.mcap         (the same page of what romano record wrote down)
  romano web --listen 192.168.1.5:8080 --certificate https.pem --token web.token
                                              (https for other machines, who show the token)
  curl -s http://127.0.0.1:8080/api/state | jq '.robots[] | {robot, home}'
  curl -X POST -H 'Content-Type: application/json' http://127.0.0.1:8080/api/stop

Whoever reaches the page can steer the robots, so it listens on this machine alone, unless there
are a certificate and a token: (umask 077; openssl rand -hex 16 > web.token). A browser asks for a
name, which does not matter, and a password, which is the token. For curl: -u :TOKEN. From elsewhere
without either, with ssh: ssh -L 8080:127.0.0.1:8080 MACHINE
)";

struct WebOptions {
    BrokerOptions broker;
    std::string listen = "127.0.0.1:8080";
    std::string certificate;
    std::string token;
    bool lets_everybody_steer = false;
    std::vector<std::string> filters = {"#"};
    double ask_s = 0;
    std::string recording;
};

Endpoint address_in(const WebOptions& options) {
    const auto endpoint = net::parse_endpoint(options.listen);
    if (!endpoint) {
        throw CommandError("--listen `" + options.listen +
                           "`: must be an IP address and a port, for example 127.0.0.1:8080");
    }
    const bool can_steer = options.recording.empty();
    if (can_steer && !net::is_loopback(*endpoint) && options.token.empty() &&
        !options.lets_everybody_steer) {
        throw CommandError("--listen `" + options.listen +
                           "`: other machines reach this address, and whoever reaches the page can "
                           "steer all robots; allowed is an address of this machine alone such as "
                           "127.0.0.1:8080, or any with --certificate and --token, or with "
                           "--let-everybody-steer");
    }
    return *endpoint;
}

/// Null: plain HTTP.
std::shared_ptr<https::Gate> gate_of(const WebOptions& options) {
    if (options.token.empty()) return nullptr;
    try {
        return std::make_shared<https::Gate>(https::GateFiles{options.certificate, options.token});
    } catch (const keys::KeyError& error) {
        throw CommandError(error.what());
    }
}

/// What browsers on this machine and others may call it.
WebApi::Names names_of_this_machine(const WebOptions& options) {
    if (!options.token.empty()) return std::nullopt;
    char host[256] = {};
    (void)::gethostname(host, sizeof host - 1);
    return std::vector<std::string>{"localhost", host, std::string{host} + ".local"};
}

void open(WebServer& server, const WebOptions& options) {
    if (const auto error = server.open(address_in(options))) {
        throw CommandError("--listen `" + options.listen + "`: " + error.message());
    }
}

void tell_where(const WebServer& server, const char* what, const https::Gate* gate) {
    std::printf("%s is shown at %s://%s/\n", what, gate != nullptr ? "https" : "http",
                net::to_text(server.address()).c_str());
    std::fflush(stdout);
}

/// A line at the first wrong token, and then one a minute at most.
class Strangers {
public:
    explicit Strangers(const https::Gate* gate) : gate_(gate) {}

    void tell(Instant now) {
        if (gate_ == nullptr || gate_->counts().wrong_tokens == told_ || now < next_) return;
        told_ = gate_->counts().wrong_tokens;
        next_ = now + 60s;
        std::fprintf(stderr, "romano web: refused: %llu wrong tokens so far, the last from %s\n",
                     static_cast<unsigned long long>(told_),
                     gate_->last_wrong().to_string().c_str());
    }

private:
    const https::Gate* gate_;
    std::uint64_t told_ = 0;
    Instant next_{};
};

void serve_fleet(const WebOptions& options) {
    (void)address_in(options);  // what is refused is refused first
    const auto gate = gate_of(options);
    boost::asio::io_context io{1};
    const Interrupt interrupt{io};
    FleetPicture picture{net::unix_time_at_zero(), options.broker.where()};
    FleetWatch watch{io,
                     {.broker = resolve_broker(io, options.broker.host, options.broker.port),
                      .client_id = options.broker.id_or("romano-web"),
                      .packets = options.broker.packets(),
                      .timing = options.broker.timing(),
                      .keep_alive = client::KeepAlive{options.broker.keep_alive_s},
                      .filters = options.filters,
                      .ask_every = std::chrono::duration_cast<Duration>(
                          std::chrono::duration<double>{options.ask_s})},
                     picture};
    WebApi api{picture, watch, names_of_this_machine(options)};
    WebServer server{io, picture, api, gate};
    open(server, options);
    Strangers strangers{gate.get()};
    bool is_told = false;
    while (!interrupt.has_come()) {
        io.run_one_for(100ms);
        strangers.tell(net::now());
        if (watch.has_begun()) {
            if (!std::exchange(is_told, true)) tell_where(server, "the fleet", gate.get());
        } else if (watch.has_failed() || watch.denial()) {
            throw CommandError(why_not(options.broker, watch.denial(), watch.was_refused()));
        }
    }
    watch.leave();
}

void serve_recording(const WebOptions& options) {
    const auto gate = gate_of(options);
    RecordingFile file = RecordingFile::open(options.recording);
    mcap::Reader reader{file};
    if (!reader.is_mcap()) {
        throw CommandError("--recording `" + options.recording +
                           "` is no recording: it does not begin as MCAP");
    }
    boost::asio::io_context io{1};
    const Interrupt interrupt{io};
    FleetPicture picture{Duration{0}};
    Playback playback{reader, std::filesystem::path{options.recording}.filename(), picture};
    WebApi api{picture, playback, names_of_this_machine(options)};
    WebServer server{io, picture, api, gate};
    open(server, options);
    Strangers strangers{gate.get()};
    tell_where(server, "the recording", gate.get());
    while (!interrupt.has_come()) {
        io.run_for(20ms);
        playback.on_tick(net::now());
        strangers.tell(net::now());
    }
}

}  // namespace

void add_web(CLI::App& program, int& exit_code) {
    auto options = std::make_shared<WebOptions>();
    CLI::App& command = *program.add_subcommand(
        "web", "Show the fleet as a page in a browser, and let people steer it there");
    options->broker.add_to(command);
    options->broker.add_key_to(command);
    command.add_option("--listen", options->listen, "Where the page is served")
        ->type_name("ADDR:PORT")
        ->capture_default_str();
    auto* const certificate =
        command
            .add_option("--certificate", options->certificate,
                        "Prove the page with this certificate: a PEM file of mode 600, with its "
                        "private key")
            ->type_name("FILE");
    auto* const token =
        command
            .add_option("--token", options->token,
                        "Serve, over https, whoever shows the word in this file of mode 600")
            ->type_name("FILE")
            ->needs(certificate);
    certificate->needs(token);
    command
        .add_flag("--let-everybody-steer", options->lets_everybody_steer,
                  "Serve other machines too: whoever reaches the page can steer all robots")
        ->excludes(token);
    command
        .add_option("--topics", options->filters,
                    "What is listened to for rates, places and messages (repeatable)")
        ->type_name("FILTER")
        ->capture_default_str();
    command
        .add_option("--ask", options->ask_s,
                    "Ask each robot where it is, if it has not said so for so long; 0: never")
        ->type_name("SECONDS")
        ->check(real_number(0.0, 3600.0))
        ->capture_default_str();
    command
        .add_option("--recording", options->recording,
                    "Show what romano record wrote down: play, pause, speed, any place; no broker "
                    "is asked, nobody is steered")
        ->type_name("FILE")
        ->excludes("--ask")
        ->excludes("--key")
        ->excludes("--topics");
    command.footer(web_examples);
    command.callback([options, &exit_code] {
        check_filters(options->filters);
        options->recording.empty() ? serve_fleet(*options) : serve_recording(*options);
        exit_code = 0;
    });
}

}  // namespace romano::experiments
