#include "experiments/cli/control.h"

#include <array>
#include <chrono>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

#include "broker/net/clock.h"
#include "experiments/cli/broker_options.h"
#include "experiments/cli/denial.h"
#include "experiments/cli/interrupt.h"
#include "experiments/operator/loop_request.h"
#include "experiments/operator/node_watch.h"
#include "experiments/operator/own_id.h"
#include "romano/cli/real_number.h"
#include "romano/control/plant.h"

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;
using control::Reason;
using control::Report;
using control::State;

constexpr const char* control_examples = R"(Examples:
  romano control 00000002 00000001                      (00000001 leads, 00000002 keeps 300 mm from it; Ctrl-C ends it)
  romano control 00000002 00000001 --law go-to --to 1000,500 --seconds 10
  romano control 00000002 00000001 --period-ms 50 --deadline-ms 400 --fallback hold
  romano control 00000002 00000001 --law 7 --parameters 0a0b   (the application's own)
  romano control 00000002 00000001 --detach             (it goes on without this command)
  romano control 00000002                               (how does its loop go?)
  romano control 00000002 --end
)";

struct ControlOptions {
    BrokerOptions broker;
    std::string plant;
    std::string controller;
    unsigned channel = 0;
    std::string law = "follow";
    std::string parameters;
    std::uint32_t distance_mm = 300;
    std::string to = "0,0";
    std::uint16_t period_ms = 20;
    std::uint16_t deadline_ms = 200;
    std::string fallback = "stop";
    bool ends_then = false;
    double seconds = 0;  // 0: until it is interrupted
    bool detaches = false;
    bool ends = false;
    bool as_json = false;
};

/// What every plant refuses.
void check_deadline(const ControlOptions& options) {
    const std::uint32_t most = control::PlantLoop::window * options.period_ms;
    if (options.deadline_ms > options.period_ms && options.deadline_ms <= most) return;
    throw CommandError("--deadline-ms " + std::to_string(options.deadline_ms) +
                       ": must be more than --period-ms, which is " +
                       std::to_string(options.period_ms) + ", and " + std::to_string(most) +
                       " at most");
}

class Supervisor {
public:
    explicit Supervisor(const ControlOptions& options)
        : options_(options),
          plant_(robot_id("plant", options.plant)),
          watch_(io_, resolve_broker(io_, options.broker.host, options.broker.port),
                 options.broker.id_or("romano-control"), options.broker.timing(),
                 options.broker.packets()) {
        watch_.set_on_message([this](std::string_view topic, Bytes data) {
            if (topic != self_.text()) return;
            const auto message = control::decode(data);
            const auto* report = message ? std::get_if<Report>(&*message) : nullptr;
            if (report == nullptr || report->plant != plant_) return;
            report_ = *report;
            const bool says_why =
                report->reason != Reason::none && report->reason != Reason::no_such_loop;
            if (report->state == State::free && says_why) {
                why_free_ = report->reason;
            }
        });
    }

    void run() {
        std::optional<control::Open> open;
        if (!options_.controller.empty() && !options_.ends) open = wish();
        watch_.subscribe(std::string{self_.text()});
        turn_until([this] { return watch_.is_connected() && watch_.is_idle(); });
        const Report found = answer_to(control::Ask{channel(), self_});
        if (found.reason != Reason::none) throw CommandError(refusal(found));
        if (options_.ends) {
            if (found.state != State::free) end(found.session);
        } else if (open) {
            open->ticket = found.session;
            keep(*open, found);
        } else {
            print(found);
        }
        watch_.leave();
        io_.run_for(50ms);
    }

private:
    [[nodiscard]] control::Channel channel() const {
        return control::Channel{static_cast<std::uint8_t>(options_.channel)};
    }

    /// Without the ticket.
    control::Open wish() {
        constexpr std::uint16_t attended_lease_s = 5;
        law_ = law_request(options_.law, options_.parameters, options_.distance_mm, options_.to);
        return {.channel = channel(),
                .ticket = control::Session::none,
                .asker = self_,
                .controller = robot_id("controller", options_.controller),
                .law = law_.law,
                .period_ms = options_.period_ms,
                .deadline_ms = options_.deadline_ms,
                .lease_s = options_.detaches ? std::uint16_t{0} : attended_lease_s,
                .fallback = fallback_named(options_.fallback),
                .ends_then = options_.ends_then,
                .parameters = law_.parameters};
    }

    void keep(const control::Open& open, const Report& found) {
        if (found.state != State::free) {
            throw CommandError(options_.plant + " is in a loop already, with " +
                               std::string{found.controller.text()} + " (romano control " +
                               options_.plant + " --end ends it)");
        }
        const control::Session session = open.ticket;
        Report report = answer_to(open);
        while (report.state == State::inviting && !interrupt_.has_come()) {
            pause(100ms);
            report = answer_to(control::Renew{session, self_});
        }
        if (report.state == State::free || report.reason != Reason::none) {
            throw CommandError(refusal(report));
        }
        const Instant end_at =
            options_.seconds > 0 ? net::now() + std::chrono::duration_cast<Duration>(
                                                    std::chrono::duration<double>{options_.seconds})
                                 : never;
        while (!options_.detaches && net::now() < end_at && !interrupt_.has_come()) {
            pause(std::min<Duration>(1s, end_at - net::now()));
            if (interrupt_.has_come()) break;
            report = answer_to(control::Renew{session, self_});
            print(report);
            if (report.state == State::free) throw CommandError(refusal(report));
        }
        if (options_.detaches) return print(report);
        end(session);
    }

    void end(control::Session session) { print(answer_to(control::End{session, self_})); }

    /// The plant tells once why a loop has ended; who renews it then hears that there is none.
    std::string refusal(const Report& report) const {
        const bool is_over = report.reason == Reason::no_such_loop;
        return "no loop of " + options_.plant +
               (options_.controller.empty() ? "" : " and " + options_.controller) + ": " +
               std::string{control::name_of(is_over ? why_free_ : report.reason)};
    }

    /// Asked again each second; commands of loops may be doubled.
    template <typename M>
    Report answer_to(const M& message) {
        std::array<std::uint8_t, control::largest_message> octets;
        const std::size_t size = control::encode(message, octets);
        report_.reset();
        const Instant give_up_at =
            net::now() + std::chrono::duration_cast<Duration>(
                             std::chrono::duration<double>{options_.broker.timeout_s});
        for (Instant again_at{}; !report_; turn()) {
            if (net::now() >= give_up_at) {
                throw CommandError(options_.plant +
                                   " does not answer: no such robot is there, or none that others "
                                   "may control (see romano robots)");
            }
            if (net::now() < again_at) continue;
            again_at = net::now() + 1s;
            watch_.publish(std::string{plant_.text()}, Bytes{octets}.first(size),
                           mqttsn::Qos::at_least_once);
        }
        return *report_;
    }

    void print(const Report& report) const {
        if (options_.as_json) {
            std::puts(to_json(report).dump().c_str());
        } else {
            std::printf("%s %s\n", options_.plant.c_str(), to_line(report).c_str());
        }
        std::fflush(stdout);
    }

    void pause(Duration time) {
        const Instant end = net::now() + time;
        while (net::now() < end && !interrupt_.has_come()) turn();
    }
    void turn() {
        io_.run_one_for(20ms);
        if (watch_.has_failed()) {
            throw CommandError(why_not(options_.broker, watch_.denial(), watch_.was_refused()));
        }
    }
    template <typename Done>
    void turn_until(const Done& done) {
        while (!done()) turn();
    }

    const ControlOptions& options_;
    const message::RomanoId plant_;
    const message::RomanoId self_ = id_of_this_machine();
    LawRequest law_;
    boost::asio::io_context io_{1};
    const Interrupt interrupt_{io_};
    NodeWatch watch_;
    std::optional<Report> report_;
    Reason why_free_ = Reason::no_such_loop;
};

}  // namespace

void add_control(CLI::App& program, int& exit_code) {
    auto options = std::make_shared<ControlOptions>();
    CLI::App& command = *program.add_subcommand(
        "control", "Let a robot control another one, and say how that goes");
    options->broker.add_to(command);
    options->broker.add_key_to(command);
    command.add_option("plant", options->plant, "The id of the robot that is controlled")
        ->required();
    command.add_option("controller", options->controller,
                       "The id of the robot that controls it; without: how its loop goes");
    command.add_option("--channel", options->channel, "Which sensor and actuator of the plant")
        ->check(CLI::Range(0U, 255U))
        ->capture_default_str();
    command
        .add_option("--law", options->law,
                    "follow, go-to, or the number of a law of the application's own")
        ->capture_default_str();
    command.add_option("--distance-mm", options->distance_mm, "Of follow: between the two")
        ->check(CLI::Range(0U, 1'000'000U))
        ->capture_default_str();
    command.add_option("--to", options->to, "Of go-to: the point X,Y in mm")->capture_default_str();
    command.add_option("--parameters", options->parameters,
                       "Of a law of the application's own: up to 32 octets in hexadecimal");
    command.add_option("--period-ms", options->period_ms, "From one sample to the next")
        ->check(CLI::Range(1, 65'535))
        ->capture_default_str();
    command
        .add_option("--deadline-ms", options->deadline_ms,
                    "How old what a command knows may become: more than a period, up to 32")
        ->check(CLI::Range(1, 65'535))
        ->capture_default_str();
    command
        .add_option("--fallback", options->fallback,
                    "What the plant does without a command: stop, hold or own-law")
        ->capture_default_str();
    command.add_flag("--end-then", options->ends_then, "The loop ends when the plant falls back");
    command.add_option("--seconds", options->seconds, "End it after so long (default: Ctrl-C)")
        ->check(real_number(0.1, 1e6));
    CLI::Option* detach =
        command.add_flag("--detach", options->detaches, "Leave it going, until --end");
    command.add_flag("--end", options->ends, "End the loop of the plant")->excludes(detach);
    command.add_flag("--json", options->as_json, "Print JSON objects, one a line");
    command.footer(control_examples);
    command.callback([options, &exit_code] {
        check_deadline(*options);
        try {
            Supervisor{*options}.run();
        } catch (const std::invalid_argument& refused) {
            throw CommandError(refused.what());
        }
        exit_code = 0;
    });
}

}  // namespace romano::experiments
