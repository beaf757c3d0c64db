#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "broker/net/clock.h"
#include "experiments/cli/broker_options.h"
#include "experiments/cli/denial.h"
#include "experiments/cli/interrupt.h"
#include "experiments/cli/robots.h"
#include "experiments/operator/message_text.h"
#include "experiments/operator/node_watch.h"
#include "experiments/operator/robot_message.h"
#include "romano/cli/real_number.h"

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;
using server::NodeEntry;
using server::NodeState;

constexpr const char* move_examples = R"(Examples:
  romano move abcd1234 front 100mm
  romano move abcd1234 front 100mm --wait 5             (until the robot says where it is)
  romano move abcd1234,00000002 rotate-left 90deg       (these two)
  romano move common back 0.5m                          (all: a topic that robots subscribe to)
  romano move abcd1234 0x8001 0a0b                      (the application's own, octets)
  romano move 0433ed81 front 500ms                      (the authors' firmware drives by time)
)";
constexpr const char* subscribe_examples = R"(Examples:
  romano subscribe-robot abcd1234 line
  romano subscribe-robot abcd1234,00000002 team/red     (then: romano move team/red front 10cm)
)";
constexpr const char* unsubscribe_examples = R"(Example:
  romano unsubscribe-robot abcd1234 line
)";
constexpr const char* request_examples = R"(Examples:
  romano request abcd1234 telemetry location            (listen: romano sub -t telemetry)
  romano request abcd1234 telemetry location --wait 5   (and print what the robot answers)
  romano request common telemetry battery
)";

struct RobotCommandOptions {
    BrokerOptions broker;
    std::string receivers;  // ids or topics, with commas between
    std::string first;      // movement, or topic
    std::string second;     // amount, or kind of data
    std::string form = "auto";
    int legacy_speed = 30;
    int qos = 2;  // no robot carries a movement out twice
    bool as_json = false;
    std::optional<double> wait_s;  // for the robot's own answer
    bool asks_for_data = false;    // `first` is the topic of the answer
};

/// What is to be said, in the receiver's form.
using Encode = std::function<Octets(const RobotCommandOptions&, Form)>;

/// Where answers come, at most 15 octets for the authors' firmware.
std::string own_answer_topic() {
    return "answer-" + std::to_string(::getpid());
}

class Commander {
public:
    Commander(const RobotCommandOptions& options, const Encode& encode)
        : options_(options),
          encode_(encode),
          watch_(io_, resolve_broker(io_, options.broker.host, options.broker.port),
                 options.broker.id_or("romano-command"), options.broker.timing(),
                 options.broker.packets()) {}
    /// Says goodbye, whatever came of it.
    ~Commander() { watch_.leave(); }
    Commander(const Commander&) = delete;
    Commander& operator=(const Commander&) = delete;

    void run() {
        if (options_.wait_s) {
            const std::string topic = options_.asks_for_data ? options_.first : own_answer_topic();
            watch_.set_on_message([this, topic](std::string_view heard, Bytes data) {
                if (heard != topic) return;
                answer_ = answer_in(romano_message(heard, data), data);
            });
            watch_.subscribe(topic);
            turn_until([this] { return watch_.is_connected() && watch_.is_idle(); });
        }
        for (const std::string& receiver : receivers_in(options_.receivers)) command(receiver);
        if (options_.as_json) std::puts(sent_.dump(2).c_str());
    }

private:
    void command(const std::string& receiver) {
        const auto id = message::RomanoId::parse(receiver);
        const std::optional<NodeEntry> node = id ? look_up(*id) : std::nullopt;
        const Form form = form_of(receiver, id.has_value(), node);
        const Octets octets = encode_(options_, form);
        answer_.reset();
        watch_.publish(receiver, octets, static_cast<mqttsn::Qos>(options_.qos));
        turn_until([this] { return watch_.is_idle(); });
        const std::string_view state = node ? server::name_of(node->state) : "";
        if (options_.wait_s) wait_for_answer(receiver, form);
        if (options_.as_json) {
            sent_.push_back({{"topic", receiver},
                             {"qos", options_.qos},
                             {"form", server::name_of(form)},
                             {"octets", hexadecimal(octets)},
                             {"state", state}});
            if (answer_) sent_.back()["answer"] = *answer_;
        } else if (answer_) {
            std::printf("%s answered: %s\n", receiver.c_str(), answer_->c_str());
        } else if (node && node->state != NodeState::connected) {
            std::printf("%s is %.*s: the message waits for it\n", receiver.c_str(),
                        static_cast<int>(state.size()), state.data());
        } else {
            std::printf(
                "sent to %s: the broker %s; %s does not say whether it got it (--wait 5 asks)\n",
                receiver.c_str(), options_.qos > 0 ? "has it" : "did not confirm it",
                id ? "the robot" : "who listens there");
        }
    }

    /// Messages of one publisher on one topic arrive in order: what a robot answers to a request
    /// that follows the command says that the command has arrived.
    void wait_for_answer(const std::string& receiver, Form form) {
        if (!options_.asks_for_data) {
            const Octets question = request_message(form, own_answer_topic(), "location");
            watch_.publish(receiver, question, static_cast<mqttsn::Qos>(options_.qos));
        }
        const Instant end = net::now() + std::chrono::duration_cast<Duration>(
                                             std::chrono::duration<double>{*options_.wait_s});
        while (!answer_ && net::now() < end) turn();
        if (answer_) return;
        std::ostringstream seconds;
        seconds << *options_.wait_s;
        throw CommandError("the broker has the message, but " + receiver +
                           " did not answer within " + seconds.str() + " s (see romano robots)");
    }

    /// In words. Robots publish what they have no sensor for as it stands (the authors' firmware
    /// and ours), which nobody shall take for data.
    std::string answer_in(const std::optional<message::Message>& message, Bytes data) const {
        if (!message) return std::string{as_text(data)};
        const auto* normal = std::get_if<message::NormalData>(&*message);
        const bool is_echo =
            options_.asks_for_data && normal != nullptr && as_text(normal->data) == options_.second;
        return to_line(*message) +
               (is_echo ? " (the request's own words: it has no such data)" : "");
    }

    std::optional<NodeEntry> look_up(const message::RomanoId& id) {
        const std::size_t heard = watch_.heard();
        watch_.subscribe(server::entry_topic(id));
        turn_until([this] { return watch_.is_connected() && watch_.is_idle(); });
        // A retained entry follows its SUBACK at once.
        const Instant patience = net::now() + 300ms;
        while (watch_.heard() == heard && net::now() < patience) turn();
        const auto found = watch_.nodes().find(id);
        return found == watch_.nodes().end() ? std::nullopt : std::optional{found->second};
    }

    Form form_of(const std::string& receiver, bool is_id, const std::optional<NodeEntry>& node) {
        if (options_.form != "auto") {
            return options_.form == "legacy" ? Form::legacy : Form::binary;
        }
        if (node) return node->form;
        if (!is_id) return Form::binary;
        throw CommandError("no robot " + receiver + " is known to the broker at " +
                           options_.broker.where() +
                           " (see romano robots; --form binary sends all the same)");
    }

    void turn() {
        io_.run_one_for(20ms);
        if (watch_.has_failed()) {
            throw CommandError(why_not(options_.broker, watch_.denial(), watch_.was_refused()));
        }
        if (interrupt_.has_come()) {
            throw CommandError("interrupted before all was said and answered");
        }
    }
    template <typename Done>
    void turn_until(const Done& done) {
        while (!done()) turn();
    }

    const RobotCommandOptions& options_;
    const Encode& encode_;
    boost::asio::io_context io_{1};
    const Interrupt interrupt_{io_};
    NodeWatch watch_;
    std::optional<std::string> answer_;
    nlohmann::ordered_json sent_ = nlohmann::ordered_json::array();
};

/// Refuses what no robot would understand, before a broker is asked which form the robot speaks.
void check(const RobotCommandOptions& options, const Encode& encode) {
    (void)receivers_in(options.receivers);
    if (options.form != "auto") {
        (void)encode(options, options.form == "legacy" ? Form::legacy : Form::binary);
        return;
    }
    try {
        (void)encode(options, Form::binary);
    } catch (const std::invalid_argument& refused) {
        try {
            (void)encode(options, Form::legacy);
        } catch (const std::invalid_argument&) {
            throw refused;
        }
    }
}

CLI::App& add_command(CLI::App& program, int& exit_code, const char* name, const char* what,
                      const char* examples, const std::shared_ptr<RobotCommandOptions>& options,
                      Encode encode) {
    CLI::App& command = *program.add_subcommand(name, what);
    options->broker.add_to(command);
    options->broker.add_key_to(command);
    command
        .add_option("robot", options->receivers,
                    "Robots' ids, or topics that they listen to, with commas between")
        ->required();
    command.add_option("-q,--qos", options->qos, "0, 1 or 2")
        ->check(CLI::Range(0, 2))
        ->capture_default_str();
    command.add_option("--form", options->form, "auto (as the robot speaks), binary or legacy")
        ->check(CLI::IsMember({"auto", "binary", "legacy"}))
        ->capture_default_str();
    command
        .add_option("--wait", options->wait_s,
                    "Wait so many seconds for an answer of the robot itself, and print it; of a "
                    "topic's listeners for the first")
        ->type_name("SECONDS")
        ->check(real_number(0.1, 3600.0));
    command.add_flag("--json", options->as_json, "Print what was sent, as a JSON array");
    command.footer(examples);
    command.callback([options, encode = std::move(encode), &exit_code] {
        try {
            check(*options, encode);
            Commander{*options, encode}.run();
        } catch (const std::invalid_argument& refused) {
            throw CommandError(refused.what());
        }
        exit_code = 0;
    });
    return command;
}

}  // namespace

void add_robot_commands(CLI::App& program, int& exit_code) {
    auto move = std::make_shared<RobotCommandOptions>();
    CLI::App& moving = add_command(
        program, exit_code, "move", "Move robots: distances in mm, cm, m; angles in deg, mdeg",
        move_examples, move, [](const RobotCommandOptions& o, Form form) {
            return move_message(form, o.first, o.second, o.legacy_speed);
        });
    moving
        .add_option("movement", move->first,
                    "front, back, left, right, rotate-left, rotate-right, or 0x8000 to 0xffff")
        ->required();
    moving.add_option("amount", move->second, "100mm, 10cm, 0.5m, 90deg, 500ms...")->required();
    moving
        .add_option("--speed", move->legacy_speed,
                    "Of robots with the authors' firmware, percent of the motors' power")
        ->check(CLI::Range(1, 100))
        ->capture_default_str();

    auto subscribe = std::make_shared<RobotCommandOptions>();
    add_command(
        program, exit_code, "subscribe-robot", "Tell robots to subscribe to a topic",
        subscribe_examples, subscribe,
        [](const RobotCommandOptions& o, Form form) { return subscribe_message(form, o.first); })
        .add_option("topic", subscribe->first, "The topic")
        ->required();

    auto unsubscribe = std::make_shared<RobotCommandOptions>();
    add_command(
        program, exit_code, "unsubscribe-robot", "Tell robots to unsubscribe from a topic",
        unsubscribe_examples, unsubscribe,
        [](const RobotCommandOptions& o, Form form) { return unsubscribe_message(form, o.first); })
        .add_option("topic", unsubscribe->first, "The topic")
        ->required();

    auto request = std::make_shared<RobotCommandOptions>();
    request->asks_for_data = true;
    CLI::App& requesting = add_command(
        program, exit_code, "request", "Tell robots to publish a kind of data on a topic",
        request_examples, request, [](const RobotCommandOptions& o, Form form) {
            return request_message(form, o.first, o.second);
        });
    requesting.add_option("topic", request->first, "Where to publish it")->required();
    requesting.add_option("data", request->second, "The kind of data, as the robot names it")
        ->required();
}

}  // namespace romano::experiments
