// Application 4 of the ROMANO paper: "ROMANO over Internet". Two networks of robots, each with
// three brokers of its own, one on IPv6 and one on IPv4; between them a mosquitto with TLS and
// credentials. The leader of the first network, which holds its uplink, is killed on the way.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <memory>
#include <stdexcept>

#include "broker/net/clock.h"
#include "experiments/applications/applications.h"
#include "experiments/measure/percentile.h"
#include "experiments/mqtt/mosquitto_server.h"
#include "experiments/process/broker_process.h"
#include "experiments/report/plot.h"
#include "experiments/robots/sockets.h"
#include "experiments/watch/broker_watch.h"
#include "firmware/posix/simulated_robot.h"

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;
using mqttsn::Qos;

constexpr std::size_t bridge_brokers = 3;
constexpr std::uint16_t bridge_port = 18840;
constexpr std::uint16_t mqtt_port = 18890;
constexpr Duration message_every = 50ms;
constexpr std::size_t messages = 240;  // of each robot
constexpr std::size_t killed_at = 80;  // messages
constexpr Duration arrives_within = 20s;

/// Brokers that are one network, and a robot of it that talks and listens.
class Network {
public:
    Network(boost::asio::io_context& io, const ApplicationOptions& options, std::size_t number,
            const MosquittoServer& server, const std::string& mqtt_address);

    void wait_until_ready(boost::asio::io_context& io);
    /// The leader: the uplink is its.
    void kill_leader() { processes_.back()->kill(); }
    [[nodiscard]] std::string topic() const { return "fleet/" + name_; }

    std::unique_ptr<firmware::SimulatedRobot> robot;
    std::map<std::string, std::vector<Instant>> arrived;  // by text, when

private:
    [[nodiscard]] std::string address(std::size_t broker) const;

    std::string name_;
    std::vector<BrokerAddress> addresses_;
    std::vector<std::unique_ptr<BrokerProcess>> processes_;
    Sockets sockets_;
    std::unique_ptr<BrokerWatch> watch_;
    std::size_t number_;
};

std::string Network::address(std::size_t broker) const {
    const BrokerAddress& at = addresses_[broker];
    const std::string ip = at.address().to_string();
    return (at.address().is_v6() ? "[" + ip + "]" : ip) + ":" + std::to_string(at.port());
}

Network::Network(boost::asio::io_context& io, const ApplicationOptions& options, std::size_t number,
                 const MosquittoServer& server, const std::string& mqtt_address)
    : name_(number == 0 ? "site-6" : "site-4"), sockets_(io), number_(number) {
    for (std::size_t i = 0; i < bridge_brokers; ++i) {
        if (number == 0) {
            addresses_.emplace_back(boost::asio::ip::address_v6::loopback(),
                                    static_cast<std::uint16_t>(bridge_port + i));
        } else {
            addresses_.emplace_back(
                boost::asio::ip::make_address(options.network + "." + std::to_string(10 + i)),
                bridge_port);
        }
        const std::string name = name_ + "-b" + std::to_string(i + 1);
        processes_.push_back(std::make_unique<BrokerProcess>(
            name, options.broker_program,
            std::vector<std::string>{"--name",
                                     name,
                                     "--listen",
                                     address(i),
                                     "--domain",
                                     std::to_string(options.domain + number),
                                     "--interface",
                                     "lo",
                                     "--rank",
                                     std::to_string(i + 1),
                                     "--uplink",
                                     server.url(mqtt_address),
                                     "--uplink-network",
                                     name_,
                                     "--uplink-topic",
                                     "fleet/#",
                                     "--uplink-ca",
                                     server.ca_file(),
                                     "--uplink-username",
                                     MosquittoServer::username,
                                     "--uplink-password-file",
                                     server.password_file()},
            options.output / (name + ".txt")));
    }
    watch_ = std::make_unique<BrokerWatch>(sockets_, addresses_[0], name_ + "-watch",
                                           client::Timing{.t_retry = 100ms, .n_retry = 200},
                                           std::function<void()>{});
}

void Network::wait_until_ready(boost::asio::io_context& io) {
    const auto wait_for = [&](const auto& done, const char* what) {
        for (const Instant end = net::now() + 20s; !done();) {
            for (const auto& process : processes_) process->expect_running();
            if (net::now() > end) throw std::runtime_error(name_ + what);
            io.run_one_for(5ms);
        }
    };
    wait_for([&] { return watch_->members_in_view_of(name_ + "-b1") == bridge_brokers; },
             ": its brokers did not find each other");
    const BrokerAddress& at = addresses_[0];
    firmware::SimulatedRobotOptions options;
    options.robot.node.id =
        message::RomanoId::parse(number_ == 0 ? "0000e006" : "0000e004").value();
    options.robot.timing.t_retry = 1s;
    options.robot.seed = number_;
    if (at.address().is_v6()) {
        options.robot.broker = {.address = at.address().to_v6().to_bytes(),
                                .port = at.port(),
                                .family = Endpoint::Family::ipv6};
    } else {
        options.robot.broker = {.port = at.port(), .family = Endpoint::Family::ipv4};
        std::ranges::copy(at.address().to_v4().to_bytes(), options.robot.broker.address.begin());
    }
    options.subscriptions = {"fleet/#"};
    options.hears = [this](std::string_view, const message::Message& message) {
        const auto* data = std::get_if<message::NormalData>(&message);
        if (data != nullptr) arrived[std::string{as_text(data->data)}].push_back(net::now());
        return true;
    };
    robot = std::make_unique<firmware::SimulatedRobot>(io, options,
                                                       [](const auto&, const std::string&) {});
    wait_for([&] { return robot->counters().established > 0; }, ": its robot was not established");
}

struct Sent {
    std::size_t from;  // which network
    std::string text;
    Qos qos;
    Instant at;  // when it was due: the wait for room in its robot's queue counts as delay
};

/// A robot holds a handful of messages, and may wait a T_retry for an answer: its program waits
/// with it.
void publish_once_there_is_room(boost::asio::io_context& io, Network& network,
                                const Sent& message) {
    const Instant end = net::now() + arrives_within;
    while (!network.robot->publish(network.topic(), message::NormalData{as_octets(message.text)},
                                   message.qos)) {
        if (net::now() > end) {
            throw std::runtime_error("a robot has had no room or no connection for " +
                                     std::to_string(arrives_within / 1s) + " s, at message " +
                                     message.text);
        }
        io.run_one_for(5ms);
    }
}

struct Figures {
    std::uint64_t sent = 0;
    std::uint64_t delivered = 0;
    std::uint64_t lost_qos0 = 0;
    std::uint64_t lost = 0;      // of QoS 1 and 2
    std::uint64_t repeated = 0;  // of QoS 1, in either network: allowed, when an answer was lost
    std::uint64_t doubled = 0;   // of QoS 0 and 2, in the other network
    std::uint64_t looped = 0;    // of QoS 0 and 2, back in its own
    std::vector<double> delays_ms;
};

double in_ms(Duration time) {
    return std::chrono::duration<double, std::milli>(time).count();
}

Figures figures_of(const std::vector<Sent>& sent, const std::array<std::unique_ptr<Network>, 2>& at,
                   std::size_t from) {
    Figures out;
    for (const Sent& each : sent) {
        if (each.from != from) continue;
        ++out.sent;
        const auto again = [&](std::uint64_t& forbidden) -> std::uint64_t& {
            return each.qos == Qos::at_least_once ? out.repeated : forbidden;
        };
        const auto& there = at[1 - from]->arrived;
        const auto found = there.find(each.text);
        if (found == there.end()) {
            ++(each.qos == Qos::at_most_once ? out.lost_qos0 : out.lost);
        } else {
            ++out.delivered;
            again(out.doubled) += found->second.size() - 1;
            out.delays_ms.push_back(in_ms(found->second[0] - each.at));
        }
        const auto here = at[from]->arrived.find(each.text);
        if (here != at[from]->arrived.end()) again(out.looped) += here->second.size() - 1;
    }
    return out;
}

void write_csv(const std::vector<Sent>& sent, const std::array<std::unique_ptr<Network>, 2>& at,
               const std::filesystem::path& folder) {
    std::ofstream csv(folder / "bridge.csv");
    csv << "from,message,qos,sent_s,delay_ms,copies_there,copies_here\n";
    for (const Sent& each : sent) {
        const auto copies = [&](std::size_t network) -> const std::vector<Instant>* {
            const auto found = at[network]->arrived.find(each.text);
            return found == at[network]->arrived.end() ? nullptr : &found->second;
        };
        const auto* there = copies(1 - each.from);
        const auto* here = copies(each.from);
        csv << (each.from == 0 ? "ipv6" : "ipv4") << ',' << each.text << ','
            << static_cast<int>(each.qos) << ',' << in_ms(each.at - sent[0].at) / 1e3 << ',';
        if (there != nullptr) csv << in_ms((*there)[0] - each.at);
        csv << ',' << (there == nullptr ? 0 : there->size()) << ','
            << (here == nullptr ? 0 : here->size()) << '\n';
    }
    if (!csv) throw std::runtime_error("cannot write into `" + folder.string() + "`");
}

void draw_delays(const std::vector<Sent>& sent, const std::array<std::unique_ptr<Network>, 2>& at,
                 Instant killed, const std::filesystem::path& folder) {
    PlotPanel panel{
        .title = "Two networks of robots over MQTT",
        .x_label = "s",
        .y_label = "delay from robot to robot (ms)",
        .series = {{.label = "IPv6 to IPv4", .points = {}, .line = false, .small = true},
                   {.label = "IPv4 to IPv6", .points = {}, .line = false, .small = true}},
        .log_y = true,
        .ticks_at_points = false,
        .marked_x = in_ms(killed - sent[0].at) / 1e3,
        .marked_label = "leader of the IPv6 network killed"};
    for (const Sent& each : sent) {
        const auto found = at[1 - each.from]->arrived.find(each.text);
        if (found == at[1 - each.from]->arrived.end()) continue;
        panel.series[each.from].points.push_back(
            {.x = in_ms(each.at - sent[0].at) / 1e3, .y = in_ms(found->second[0] - each.at)});
    }
    const auto svg = draw({.name = "bridge", .panels = {panel}}, folder);
    if (svg) std::ofstream(folder / "bridge.svg") << *svg << '\n';
}

}  // namespace

void run_bridge(const ApplicationOptions& options) {
    boost::asio::io_context io{1};
    std::filesystem::create_directories(options.output);
    const std::string v4 = options.network + ".250";
    const MosquittoServer server(options.output / "mosquitto", {"::1", v4}, mqtt_port);
    std::array<std::unique_ptr<Network>, 2> networks{
        std::make_unique<Network>(io, options, 0, server, "::1"),
        std::make_unique<Network>(io, options, 1, server, v4)};
    for (const auto& network : networks) network->wait_until_ready(io);

    // The uplinks are up when something has got through, both ways.
    const auto has_come = [&](std::size_t network, const std::string& text) {
        return networks[network]->arrived.contains(text);
    };
    for (const Instant end = net::now() + 20s; !has_come(1, "open0") || !has_come(0, "open1");) {
        if (net::now() > end) throw std::runtime_error("the networks do not hear each other");
        for (std::size_t i = 0; i < 2; ++i) {
            const std::string text = "open" + std::to_string(i);
            networks[i]->robot->publish(networks[i]->topic(), message::NormalData{as_octets(text)},
                                        Qos::at_most_once);
        }
        for (const Instant turn = net::now() + 200ms; net::now() < turn;) io.run_one_for(5ms);
    }

    std::vector<Sent> sent;
    Instant killed{};
    Instant next = net::now();
    for (std::size_t number = 0; number < messages; ++number, next += message_every) {
        while (net::now() < next) io.run_one_for(1ms);
        if (number == killed_at) {
            killed = net::now();
            networks[0]->kill_leader();
        }
        for (std::size_t from = 0; from < 2; ++from) {
            Sent each{.from = from,
                      .text = std::to_string(from) + "-" + std::to_string(number),
                      .qos = static_cast<Qos>(number % 3),
                      .at = next};
            publish_once_there_is_room(io, *networks[from], each);
            sent.push_back(std::move(each));
        }
    }
    const auto is_complete = [&] {
        return figures_of(sent, networks, 0).lost + figures_of(sent, networks, 1).lost == 0;
    };
    for (const Instant end = net::now() + arrives_within; net::now() < end && !is_complete();) {
        for (const Instant turn = net::now() + 100ms; net::now() < turn;) io.run_one_for(5ms);
    }
    for (const Instant end = net::now() + 2s; net::now() < end;)
        io.run_one_for(5ms);  // late copies

    write_csv(sent, networks, options.output);
    draw_delays(sent, networks, killed, options.output);
    std::printf(
        "way           sent  delivered  lost QoS 0  lost QoS 1, 2  repeated QoS 1  doubled  looped"
        "  p50 ms   p99 ms\n");
    for (std::size_t from = 0; from < 2; ++from) {
        const Figures figures = figures_of(sent, networks, from);
        const Percentiles delay{figures.delays_ms};
        std::printf("%s  %4llu  %9llu  %10llu  %13llu  %14llu  %7llu  %6llu  %6.1f  %7.1f\n",
                    from == 0 ? "IPv6 to IPv4" : "IPv4 to IPv6",
                    static_cast<unsigned long long>(figures.sent),
                    static_cast<unsigned long long>(figures.delivered),
                    static_cast<unsigned long long>(figures.lost_qos0),
                    static_cast<unsigned long long>(figures.lost),
                    static_cast<unsigned long long>(figures.repeated),
                    static_cast<unsigned long long>(figures.doubled),
                    static_cast<unsigned long long>(figures.looped),
                    delay.at(0.5).value_or(std::nan("")), delay.at(0.99).value_or(std::nan("")));
        if (figures.lost + figures.doubled + figures.looped != 0) {
            throw std::runtime_error("messages were lost, doubled or looped");
        }
    }
}

}  // namespace romano::experiments
