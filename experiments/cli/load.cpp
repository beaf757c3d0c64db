#include "experiments/cli/load.h"

#include <sys/socket.h>
#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <memory>
#include <string>

#include "broker/net/asio_endpoint.h"
#include "broker/net/endpoint_text.h"
#include "broker/net/socket_address.h"
#include "experiments/cli/broker_options.h"
#include "experiments/load/load_run.h"
#include "experiments/load/mqttsn_clients.h"
#include "romano/cli/real_number.h"
#include "romano/mqttsn/topic.h"

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;

constexpr const char* load_examples = R"(Examples:
  romano load                                       (closed loop, one publisher, one subscriber)
  romano load -h 192.168.1.5 --rate 10000           (10,000 messages a second: what is the latency?)
  romano load --subscribers 50                      (fan-out: each message goes to 50)
  romano load --subscribers 50 --cell-group 239.1.1.1:1890      (by one datagram for all of them)
  romano load --publishers 20 --subscribers 20 --topics 20 -q 1
  romano load -h ::1 -p 1884 --rate 200 -q 2 --payload 200 --duration 60 --json
  romano load -h 127.0.0.1 --also 127.0.0.2 -q 1    (from one broker of a cluster to another)
  romano load --publishers 5000 --subscribers 5000 --topics 10000 --one-socket
In a closed loop --in-flight messages are on their way; where one has arrived, the next leaves.
Publisher i publishes on topic i mod N, or on each N-th topic; subscribers likewise.
Exit code: 0; 1 when something was lost, doubled at QoS 2, or refused; 2 when nothing was measured.
)";

volatile std::sig_atomic_t interrupted = 0;

struct LoadOptions {
    BrokerOptions broker;
    std::vector<std::string> also;  // more hosts
    LoadPlan plan;
    int qos = 0;
    double rate_per_s = 0;
    double warm_up_s = 1;
    double duration_s = 5;
    double drain_s = 5;
    std::string cell_group;
    bool one_socket = false;
    bool never_sleep = false;
    bool json = false;
};

Duration in_time(double seconds) {
    return std::chrono::duration_cast<Duration>(std::chrono::duration<double>{seconds});
}

/// Throws CommandError for what could not be measured.
void check(const LoadPlan& plan) {
    if (!mqttsn::is_valid_topic_name(plan.topic_name(0))) {
        throw CommandError("--topic `" + plan.topic_prefix +
                           "`: must be a topic name: UTF-8, without '+' and '#'");
    }
    if (plan.topic_prefix.starts_with('$')) {
        throw CommandError(
            "--topic `" + plan.topic_prefix +
            "`: topics that begin with '$' are the broker's own, and clients may not "
            "publish there");
    }
    const bool is_answered = plan.subscribers != 0 || plan.qos != mqttsn::Qos::at_most_once;
    if (!plan.rate_per_s && !is_answered) {
        throw CommandError(
            "--subscribers 0 at QoS 0: nothing comes back that would turn the closed loop; give "
            "--rate, or -q 1");
    }
}

std::vector<Endpoint> brokers_of(const LoadOptions& options) {
    boost::asio::io_context io{1};
    std::vector<std::string> hosts{options.broker.host};
    hosts.insert(hosts.end(), options.also.begin(), options.also.end());
    std::vector<Endpoint> brokers;
    for (const std::string& host : hosts) {
        brokers.push_back(net::to_endpoint(resolve_broker(io, host, options.broker.port)));
    }
    return brokers;
}

/// On a terminal, in one line that is redrawn; else silent.
class Progress {
public:
    explicit Progress(bool shown) : shown_(shown) {}
    ~Progress() { erase(); }
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    void show(const std::string& phase, double share) {
        const auto now = std::chrono::steady_clock::now();
        if (!shown_ || now - last_ < 100ms) return;
        last_ = now;
        std::fprintf(stderr, "\r\033[K%s: %.0f %%", phase.c_str(), 100 * share);
        std::fflush(stderr);
    }
    void erase() const {
        if (shown_) std::fputs("\r\033[K", stderr);
    }

private:
    bool shown_;
    std::chrono::steady_clock::time_point last_{};
};

Endpoint cell_of(const LoadOptions& options, const Endpoint& broker) {
    if (options.cell_group.empty()) return {};
    const auto group = net::parse_endpoint(options.cell_group);
    if (!group || group->port == 0 || !net::is_multicast(*group)) {
        throw CommandError("--cell-group `" + options.cell_group +
                           "`: must be a multicast group and port, such as 239.1.1.1:1890");
    }
    if (group->family != broker.family) {
        throw CommandError("--cell-group `" + options.cell_group +
                           "`: is not of the family of -h " + options.broker.host);
    }
    return *group;
}

int run(const LoadOptions& options) {
    MqttsnOptions mqttsn{.brokers = brokers_of(options),
                         .sockets = options.one_socket ? SocketUse::shared : SocketUse::one_each,
                         .timing = options.broker.timing(),
                         .keep_alive = std::chrono::seconds{options.broker.keep_alive_s},
                         .id_prefix = options.broker.id_or("load"),
                         .cell_group = {}};
    mqttsn.cell_group = cell_of(options, mqttsn.brokers.front());
    mqttsn.timing.t_wait = 1s;
    MqttsnClients clients{options.plan, mqttsn};
    Progress progress{::isatty(STDERR_FILENO) != 0};
    for (const int signal : {SIGINT, SIGTERM}) {
        std::signal(signal, [](int) { interrupted = 1; });
    }
    LoadRun run{options.plan,
                clients,
                {.on_progress = [&](const std::string& phase,
                                    double share) { progress.show(phase, share); },
                 .on_measuring = {},
                 .on_measured = {},
                 .is_stopped = [] { return interrupted != 0; },
                 .never_sleeps = options.never_sleep}};
    const LoadFigures figures = run.run();
    progress.erase();
    const std::string report =
        options.json ? json_of(options.plan, figures) + "\n" : text_of(options.plan, figures);
    std::fputs(report.c_str(), stdout);
    const bool doubled = options.plan.qos == mqttsn::Qos::exactly_once && figures.duplicates != 0;
    const bool whole = figures.lost() == 0 && figures.refused == 0 && figures.lost_clients == 0;
    return whole && !doubled ? 0 : 1;
}

}  // namespace

void add_load(CLI::App& program, int& exit_code) {
    auto options = std::make_shared<LoadOptions>();
    CLI::App& command = *program.add_subcommand(
        "load", "Load any MQTT-SN broker or gateway; measure throughput, latency and loss");
    options->broker.timeout_s = 10;  // gateways to another broker may be slow
    options->broker.add_to(command);
    command
        .add_option("--also", options->also,
                    "More brokers of the cluster, on the same port: publisher i lives at the i-th "
                    "broker in turn, subscriber i at the next one, so that messages cross")
        ->type_name("HOST");
    LoadPlan& plan = options->plan;
    command.add_option("--publishers", plan.publishers, "Clients that publish")
        ->check(CLI::Range(1, 100'000))
        ->capture_default_str();
    command.add_option("--subscribers", plan.subscribers, "Clients that subscribe")
        ->check(CLI::Range(0, 100'000))
        ->capture_default_str();
    command.add_option("--topics", plan.topics, "Topics, dealt to publishers and subscribers")
        ->check(CLI::Range(1, 100'000))
        ->capture_default_str();
    command.add_option("-q,--qos", options->qos, "0, 1 or 2")
        ->check(CLI::Range(0, 2))
        ->capture_default_str();
    command.add_option("--payload", plan.payload_octets, "Octets of a message")
        ->check(CLI::Range(int{LoadPlan::least_payload_octets}, 65'000))
        ->capture_default_str();
    CLI::Option* rate =
        command
            .add_option("--rate", options->rate_per_s,
                        "Messages a second, of all publishers together (else a closed loop)")
            ->check(real_number(0.001, 1e7));
    command
        .add_option("--in-flight", plan.in_flight,
                    "Messages on their way at the same time, in the closed loop")
        ->check(CLI::Range(1, 100'000))
        ->capture_default_str()
        ->excludes(rate);
    command.add_option("--warm-up", options->warm_up_s, "Seconds of load before measuring")
        ->check(real_number(0.0, 3600.0))
        ->capture_default_str();
    command.add_option("--duration", options->duration_s, "Seconds to measure")
        ->check(real_number(0.05, 86'400.0))
        ->capture_default_str();
    command
        .add_option("--drain", options->drain_s,
                    "Seconds without an arrival after which the rest is taken for lost")
        ->check(real_number(0.1, 600.0))
        ->capture_default_str();
    command.add_option("--topic", plan.topic_prefix, "The topics are NAME/0, NAME/1...")
        ->type_name("NAME")
        ->capture_default_str();
    CLI::Option* cell_group =
        command
            .add_option("--cell-group", options->cell_group,
                        "Subscribers listen there, too, to what the broker sends once for many "
                        "(its --cell-group)")
            ->type_name("ADDR:PORT");
    command
        .add_flag("--one-socket", options->one_socket,
                  "All clients on one socket, each with an address of its own (127.1.0.0 and "
                  "up): the generator needs less CPU. For brokers on 127.0.0.0/8")
        ->excludes(cell_group);
    command.add_flag(
        "--never-sleep", options->never_sleep,
        "Poll without waiting: takes a core, and keeps this program's own wake-ups out "
        "of the latency");
    command.add_flag("--json", options->json, "Print the figures as JSON");
    command.footer(load_examples);
    command.callback([options, rate, &exit_code] {
        LoadPlan& chosen = options->plan;
        chosen.qos = static_cast<mqttsn::Qos>(options->qos);
        if (rate->count() > 0) chosen.rate_per_s = options->rate_per_s;
        chosen.warm_up = in_time(options->warm_up_s);
        chosen.duration = in_time(options->duration_s);
        chosen.drain = in_time(options->drain_s);
        check(chosen);
        exit_code = run(*options);
    });
}

}  // namespace romano::experiments
