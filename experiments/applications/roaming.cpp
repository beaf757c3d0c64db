// Nearest broker: robots with the firmware's code drive along a row of real brokers, each with a
// cell of its own, and choose among them by signal strength. What moving costs: time and messages.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <set>
#include <stdexcept>

#include "broker/net/clock.h"
#include "experiments/applications/applications.h"
#include "experiments/applications/row_of_cells.h"
#include "experiments/measure/percentile.h"
#include "experiments/operator/node_watch.h"
#include "experiments/process/broker_process.h"
#include "experiments/report/plot.h"
#include "experiments/robots/sockets.h"
#include "experiments/watch/broker_watch.h"
#include "firmware/posix/simulated_robot.h"
#include "romano/message/codec.h"

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;
using mqttsn::Qos;

constexpr std::size_t row_brokers = 3;
constexpr std::uint16_t row_port = 18830;
constexpr Duration roaming_message_every = 50ms;  // 20 a second, to or from each robot
constexpr Duration settle = 1s;                   // for late copies
constexpr Duration roaming_arrives_within = 30s;  // QoS 1 and 2, after the last was handed over

enum class Way : std::uint8_t { to_robots, from_robots };
const char* to_text(Way way) {
    return way == Way::to_robots ? "to robots" : "from robots";
}

struct Outcome {
    Qos qos;
    Way way;
    std::uint64_t sent = 0;
    std::uint64_t refused = 0;  // the sender's queue was full
    std::uint64_t lost = 0;
    std::uint64_t doubled = 0;
    std::uint64_t worst_move = 0;     // most messages lost in one move
    std::uint64_t lost_by_radio = 0;  // datagrams
    std::vector<Move> moves;
    std::vector<Strength> strengths;  // of the first robot
};

/// The numbers of the messages that arrived, and when each was sent.
struct Book {
    std::vector<Instant> sent_at;
    std::map<std::uint32_t, int> arrived;

    std::array<std::uint8_t, 8> next(Instant now) {
        sent_at.push_back(now);
        std::array<std::uint8_t, 8> digits{};
        auto number = static_cast<std::uint32_t>(sent_at.size() - 1);
        for (std::size_t i = digits.size(); i > 0; --i, number /= 10) {
            digits[i - 1] = static_cast<std::uint8_t>('0' + number % 10);
        }
        return digits;
    }
    void on_message(Bytes data) {
        const std::string_view text = as_text(data);
        std::uint32_t number = 0;
        std::from_chars(text.data(), text.data() + text.size(), number);
        ++arrived[number];
    }
};

std::string id_of(std::size_t robot) {
    return "0000d00" + std::to_string(robot);
}

/// One run: robots drive up and down the row while messages flow one way at one QoS.
class Run {
public:
    Run(boost::asio::io_context& io, const RowOfCells& row, std::size_t robots, Outcome& outcome,
        std::uint64_t seed);
    void drive(Duration time);

private:
    struct Roamer {
        std::unique_ptr<RowRadio> radio;
        std::unique_ptr<firmware::SimulatedRobot> robot;
        Book book;
    };

    void run_until(Instant end, bool talks);
    void wait_for(const std::function<bool()>& done, const char* what);
    void talk(Instant now);
    void on_station_event(const client::Event& event);
    void tell();

    boost::asio::io_context& io_;
    Outcome& outcome_;
    std::vector<Roamer> roamers_;
    SocketClient station_;
    bool station_subscribed_ = false;
    Instant next_message_ = never;
};

Run::Run(boost::asio::io_context& io, const RowOfCells& row, std::size_t robots, Outcome& outcome,
         std::uint64_t seed)
    : io_(io),
      outcome_(outcome),
      station_(io, row.broker(0), {.t_retry = 1s}, seed,
               [this](const client::Event& event) { on_station_event(event); }) {
    roamers_.resize(robots);
    for (std::size_t i = 0; i < robots; ++i) {
        Roamer& roamer = roamers_[i];
        roamer.radio = std::make_unique<RowRadio>(row, seed * 1000 + i);
        firmware::SimulatedRobotOptions options;
        options.robot.node.id = message::RomanoId::parse(id_of(i)).value();
        options.robot.timing.t_retry = 1s;
        options.robot.seed = seed * 1000 + i;
        options.local.family = 4;
        options.radio = roamer.radio.get();
        options.hears = [&roamer](std::string_view, const message::Message& message) {
            const auto* data = std::get_if<message::NormalData>(&message);
            if (data != nullptr) roamer.book.on_message(data->data);
            return true;
        };
        roamer.robot = std::make_unique<firmware::SimulatedRobot>(
            io, options, [](const auto&, const std::string&) {});
    }
    station_.connect({.client_id = "station", .clean_session = true});
    (void)station_.subscribe(client::topic_name("from/+"), Qos::exactly_once);
    wait_for(
        [this] {
            return station_subscribed_ && std::ranges::all_of(roamers_, [](const Roamer& roamer) {
                       return roamer.robot->counters().established > 0;
                   });
        },
        "the robots were not established");
    run_until(net::now() + 300ms, false);  // subscriptions reach the other brokers
}

void Run::on_station_event(const client::Event& event) {
    if (std::holds_alternative<client::Subscribed>(event)) station_subscribed_ = true;
    const auto* received = std::get_if<client::Received>(&event);
    if (received == nullptr || received->data.size() < 3) return;
    const std::string_view topic = received->topic.name;
    roamers_[static_cast<std::size_t>(topic.back() - '0')].book.on_message(
        received->data.subspan(2));  // behind the ROMANO header
}

void Run::talk(Instant now) {
    for (std::size_t i = 0; i < roamers_.size(); ++i) {
        Roamer& roamer = roamers_[i];
        const auto digits = roamer.book.next(now);
        const message::NormalData data{digits};
        bool taken = false;
        if (outcome_.way == Way::from_robots) {
            taken = roamer.robot->publish("from/" + std::to_string(i), data, outcome_.qos);
        } else {
            std::array<std::uint8_t, message::max_message> octets{};
            const std::size_t size = message::encode(data, octets);
            taken = static_cast<bool>(station_.publish(
                client::topic_name(id_of(i)), Bytes{octets}.first(size), {.qos = outcome_.qos}));
        }
        if (taken) continue;
        roamer.book.sent_at.pop_back();
        ++outcome_.refused;
    }
}

void Run::run_until(Instant end, bool talks) {
    if (talks) next_message_ = net::now();
    while (net::now() < end) {
        io_.run_one_for(1ms);
        if (talks && net::now() >= next_message_) {
            next_message_ += roaming_message_every;
            talk(net::now());
        }
    }
}

void Run::wait_for(const std::function<bool()>& done, const char* what) {
    const Instant end = net::now() + 20s;
    while (!done()) {
        if (net::now() > end) throw std::runtime_error(what);
        io_.run_one_for(5ms);
    }
}

void Run::drive(Duration time) {
    for (Roamer& roamer : roamers_) roamer.radio->set_out();
    run_until(net::now() + time, true);
    for (Roamer& roamer : roamers_) roamer.radio->stop();
    const auto is_complete = [this] {
        return std::ranges::all_of(roamers_, [](const Roamer& roamer) {
            return roamer.book.arrived.size() >= roamer.book.sent_at.size();
        });
    };
    const bool is_kept = outcome_.qos != Qos::at_most_once;
    for (const Instant end = net::now() + roaming_arrives_within;
         is_kept && net::now() < end && !is_complete();) {
        io_.run_one_for(5ms);
    }
    run_until(net::now() + settle, false);
    tell();
}

std::size_t nearest_move(const std::vector<Move>& moves, Instant at) {
    auto found = std::ranges::lower_bound(moves, at, {}, &Move::begun_at);
    if (found != moves.begin() &&
        (found == moves.end() || at - std::prev(found)->begun_at < found->begun_at - at)) {
        --found;
    }
    return static_cast<std::size_t>(found - moves.begin());
}

void Run::tell() {
    for (const Roamer& roamer : roamers_) {
        const auto& moves = roamer.radio->moves();
        std::vector<std::uint64_t> lost_in(moves.size() + 1);
        for (std::uint32_t number = 0; number < roamer.book.sent_at.size(); ++number) {
            ++outcome_.sent;
            const auto arrived = roamer.book.arrived.find(number);
            if (arrived == roamer.book.arrived.end()) {
                ++outcome_.lost;
                ++lost_in[nearest_move(moves, roamer.book.sent_at[number])];
            } else {
                outcome_.doubled += static_cast<std::uint64_t>(arrived->second - 1);
            }
        }
        outcome_.worst_move = std::max(outcome_.worst_move, std::ranges::max(lost_in));
        outcome_.lost_by_radio += roamer.radio->lost();
        outcome_.moves.insert(outcome_.moves.end(), moves.begin(), moves.end());
    }
    outcome_.strengths = roamers_[0].radio->strengths();
}

std::vector<double> times_ms(const std::vector<Move>& moves) {
    std::vector<double> times;
    for (const Move& move : moves) {
        if (move.done_at == never) continue;
        times.push_back(
            std::chrono::duration<double, std::milli>(move.done_at - move.begun_at).count());
    }
    return times;
}

void print_head() {
    std::puts(
        "QoS  way          messages  refused  lost  in a move  doubled  moves   move p50     p99   "
        "  max "
        "(ms)");
    std::fflush(stdout);
}

void print_row(const Outcome& outcome) {
    const auto samples = times_ms(outcome.moves);
    const Percentiles move{samples};
    const auto at = [&](double share) { return move.at(share).value_or(std::nan("")); };
    std::printf("%3d  %-11s  %8llu  %7llu  %4llu  %9llu  %7llu  %5zu  %9.1f  %6.1f  %6.1f\n",
                static_cast<int>(outcome.qos), to_text(outcome.way),
                static_cast<unsigned long long>(outcome.sent),
                static_cast<unsigned long long>(outcome.refused),
                static_cast<unsigned long long>(outcome.lost),
                static_cast<unsigned long long>(outcome.worst_move),
                static_cast<unsigned long long>(outcome.doubled), outcome.moves.size(), at(0.5),
                at(0.99), at(1));
    std::fflush(stdout);  // the next run takes half a minute
}

void write_results(const std::vector<Outcome>& outcomes, const std::filesystem::path& folder) {
    std::ofstream csv(folder / "roaming.csv");
    csv << "qos,way,messages,refused,lost,lost_in_one_move_at_most,doubled,moves,unfinished_moves,"
           "move_p50_ms,move_p99_ms,move_max_ms,datagrams_lost_by_radio\n";
    PlotPanel times{.title = "Time of a move",
                    .x_label = "QoS",
                    .y_label = "ms until the new broker is heard",
                    .series = {},
                    .y_from = 0};
    for (const Outcome& outcome : outcomes) {
        const auto samples = times_ms(outcome.moves);
        const Percentiles move{samples};
        const auto at = [&](double share) { return move.at(share).value_or(std::nan("")); };
        const int qos = static_cast<int>(outcome.qos);
        csv << qos << ',' << to_text(outcome.way) << ',' << outcome.sent << ',' << outcome.refused
            << ',' << outcome.lost << ',' << outcome.worst_move << ',' << outcome.doubled << ','
            << outcome.moves.size() << ',' << outcome.moves.size() - samples.size() << ','
            << at(0.5) << ',' << at(0.99) << ',' << at(1) << ',' << outcome.lost_by_radio << '\n';
        auto series = std::ranges::find(times.series, to_text(outcome.way), &PlotSeries::label);
        if (series == times.series.end()) {
            series = times.series.insert(
                series, {.label = to_text(outcome.way), .points = {}, .line = false});
        }
        for (const double time : samples) {
            series->points.push_back(
                {.x = qos + (outcome.way == Way::to_robots ? -0.1 : 0.1), .y = time});
        }
    }
    if (!csv) throw std::runtime_error("cannot write into `" + folder.string() + "`");

    PlotPanel strength{.title = "One robot on its way along three brokers",
                       .x_label = "s",
                       .y_label = "strength (dBm)",
                       .series = {},
                       .ticks_at_points = false};
    for (std::size_t broker = 0; broker <= row_brokers; ++broker) {
        PlotSeries series{.label = broker < row_brokers ? "broker " + std::to_string(broker + 1)
                                                        : "the one it talks to",
                          .points = {},
                          .line = broker == row_brokers,
                          .small = broker < row_brokers};
        for (const Strength& at : outcomes.front().strengths) {
            const std::size_t which = broker < row_brokers ? broker : at.chosen;
            series.points.push_back({.x = at.at_s, .y = at.dbm[which]});
        }
        strength.series.push_back(std::move(series));
    }
    const auto svg = draw({.name = "roaming", .panels = {strength, times}}, folder);
    if (svg) std::ofstream(folder / "roaming.svg") << *svg << '\n';
}

}  // namespace

void run_roaming(const ApplicationOptions& options) {
    boost::asio::io_context io{1};
    const RowOfCells row(options.network, row_port, row_brokers,
                         {.metres_between = 12, .metres_a_second = options.brief ? 8.0 : 3.0});
    std::filesystem::create_directories(options.output);
    std::vector<std::unique_ptr<BrokerProcess>> processes;
    for (std::size_t i = 0; i < row_brokers; ++i) {
        const std::string name = "b" + std::to_string(i + 1);
        processes.push_back(std::make_unique<BrokerProcess>(
            name, options.broker_program,
            std::vector<std::string>{"--name", name, "--listen", row.address(i), "--domain",
                                     std::to_string(options.domain), "--interface", "lo",
                                     "--gateway-id", std::to_string(i + 1),
                                     "--detection-timeout-ms", "500"},
            options.output / ("roaming-" + name + ".txt")));
    }
    Sockets sockets{io};
    BrokerWatch watch(sockets, row.broker(0), "roaming-watch", {.t_retry = 100ms, .n_retry = 200},
                      {});
    for (const Instant end = net::now() + 20s; watch.members_in_view_of("b1") < row_brokers;) {
        for (const auto& process : processes) process->expect_running();
        if (net::now() > end) throw std::runtime_error("the brokers did not find each other");
        io.run_one_for(5ms);
    }
    print_head();
    std::vector<Outcome> outcomes;
    const Duration time = std::chrono::duration_cast<Duration>(
        std::chrono::duration<double>(row.lap_s() * (options.brief ? 1 : 2)));
    for (const Way way : {Way::to_robots, Way::from_robots}) {
        for (const Qos qos : {Qos::at_most_once, Qos::at_least_once, Qos::exactly_once}) {
            Outcome& outcome = outcomes.emplace_back();
            outcome.qos = qos;
            outcome.way = way;
            Run(io, row, options.brief ? 2 : 4, outcome, options.seed + outcomes.size())
                .drive(time);
            print_row(outcome);
        }
    }
    write_results(outcomes, options.output);
    std::size_t moves = 0;
    for (const Outcome& outcome : outcomes) {
        moves += outcome.moves.size();
        if (outcome.qos == Qos::at_most_once) continue;  // nobody promised
        if (outcome.lost != 0) {
            throw std::runtime_error("moves lost " + std::to_string(outcome.lost) +
                                     " messages at QoS " +
                                     std::to_string(static_cast<int>(outcome.qos)));
        }
        if (outcome.qos == Qos::exactly_once && outcome.doubled != 0) {
            throw std::runtime_error("a message of QoS 2 arrived twice");
        }
    }
    if (moves == 0) throw std::runtime_error("no robot moved to another broker");
}

}  // namespace romano::experiments
