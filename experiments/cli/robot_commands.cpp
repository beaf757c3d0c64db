#include <chrono>
#include <cstdio>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>

#include "broker/net/clock.h"
#include "experiments/cli/broker_options.h"
#include "experiments/cli/robots.h"
#include "experiments/operator/node_watch.h"
#include "experiments/operator/robot_message.h"

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;
using server::NodeEntry;
using server::NodeState;

constexpr const char* move_examples = R"(Examples:
  romano move abcd1234 front 100mm
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
};

/// What is to be said, in the receiver's form.
using Encode = std::function<Octets(const RobotCommandOptions&, Form)>;

std::string hexadecimal(const Octets& octets) {
    std::string text;
    for (const std::uint8_t octet : octets) {
        char digits[3];
        std::snprintf(digits, sizeof digits, "%02x", unsigned{octet});
        text += digits;
    }
    return text;
}

class Commander {
public:
    Commander(const RobotCommandOptions& options, const Encode& encode)
        : options_(options),
          encode_(encode),
          watch_(io_, resolve_broker(io_, options.broker.host, options.broker.port),
                 options.broker.id_or("romano-command"), options.broker.timing()) {}

    void run() {
        for (const std::string& receiver : receivers_in(options_.receivers)) command(receiver);
        watch_.leave();
        if (options_.as_json) std::puts(sent_.dump(2).c_str());
    }

private:
    void command(const std::string& receiver) {
        const auto id = message::RomanoId::parse(receiver);
        const std::optional<NodeEntry> node = id ? look_up(*id) : std::nullopt;
        const Form form = form_of(receiver, id.has_value(), node);
        const Octets octets = encode_(options_, form);
        watch_.publish(receiver, octets, static_cast<mqttsn::Qos>(options_.qos));
        turn_until([this] { return watch_.is_idle(); });
        const std::string_view state = node ? server::name_of(node->state) : "";
        if (options_.as_json) {
            sent_.push_back({{"topic", receiver},
                             {"qos", options_.qos},
                             {"form", server::name_of(form)},
                             {"octets", hexadecimal(octets)},
                             {"state", state}});
        } else if (node && node->state != NodeState::connected) {
            std::printf("%s is %.*s: the message waits for it\n", receiver.c_str(),
                        static_cast<int>(state.size()), state.data());
        } else {
            std::printf("sent to %s\n", receiver.c_str());
        }
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
        if (watch_.was_denied()) {
            throw CommandError("the broker at " + options_.broker.where() + " refused this");
        }
        if (watch_.has_failed()) {
            throw CommandError(options_.broker.unreachable(watch_.was_refused()));
        }
    }
    template <typename Done>
    void turn_until(const Done& done) {
        while (!done()) turn();
    }

    const RobotCommandOptions& options_;
    const Encode& encode_;
    boost::asio::io_context io_{1};
    NodeWatch watch_;
    nlohmann::ordered_json sent_ = nlohmann::ordered_json::array();
};

CLI::App& add_command(CLI::App& program, int& exit_code, const char* name, const char* what,
                      const char* examples, const std::shared_ptr<RobotCommandOptions>& options,
                      Encode encode) {
    CLI::App& command = *program.add_subcommand(name, what);
    options->broker.add_to(command);
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
    command.add_flag("--json", options->as_json, "Print what was sent, as a JSON array");
    command.footer(examples);
    command.callback([options, encode = std::move(encode), &exit_code] {
        try {
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
