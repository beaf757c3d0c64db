#include "experiments/cli/sub.h"

#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <csignal>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "experiments/cli/broker_options.h"
#include "experiments/cli/denial.h"
#include "experiments/operator/message_text.h"
#include "romano/cli/real_number.h"
#include "romano/mqttsn/topic.h"

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;

constexpr int timed_out = 27;  // as mosquitto_sub says it

constexpr const char* sub_examples = R"(Examples:
  romano sub -t 'robots/+/pose' -v
  romano sub -h 127.0.0.2 -t '#' -q 2
  romano sub -t init-info -C 1 -W 10                (one message, within 10 seconds)
  romano sub -t common -t '+' -v                    (robots' heartbeats and commands, in words)
  romano sub -t telemetry --json | jq .romano.x_mm
  romano sub -i dashboard -c -t alarms -q 1         (a session that is kept: run it again later)
Exit code: 0; 2 when it cannot be done; 27 when -W ran out.
)";

struct SubOptions {
    BrokerOptions broker;
    std::vector<std::string> topics;
    std::vector<std::uint16_t> predefined;
    int qos = 0;
    bool keep_session = false;
    bool verbose = false;
    bool no_retained = false;
    bool raw = false;
    bool as_json = false;
    std::uint64_t count = 0;
    double timeout_s = 0;
};

class Subscriber {
public:
    explicit Subscriber(const SubOptions& options)
        : options_(options),
          client_id_(options.broker.id_or("romano-sub")),
          interrupts_(io_, SIGINT, SIGTERM),
          timeout_(io_),
          client_(std::make_unique<WatcherClient>(
              io_, resolve_broker(io_, options.broker.host, options.broker.port),
              options.broker.timing(), static_cast<std::uint64_t>(::getpid()),
              [this](const client::Event& event) { on_event(event); }, options.broker.packets())) {
        for (const std::string& topic : options_.topics) {
            topics_.push_back(client::topic_name(topic));
        }
        for (const std::uint16_t id : options_.predefined) {
            topics_.push_back(client::predefined_topic(mqttsn::TopicId{id}));
        }
    }

    int run() {
        interrupts_.async_wait([this](const auto& stopped, int) {
            if (!stopped) finish(0);
        });
        if (options_.timeout_s > 0) {
            timeout_.expires_after(std::chrono::duration_cast<std::chrono::nanoseconds>(
                std::chrono::duration<double>{options_.timeout_s}));
            timeout_.async_wait([this](const auto& stopped) {
                if (!stopped) on_time_out();
            });
        }
        connect();
        io_.run();
        if (!error_.empty()) throw CommandError(error_);
        return exit_code_;
    }

private:
    void connect() {
        client_->connect({.client_id = client_id_,
                          .clean_session = !options_.keep_session,
                          .keep_alive = std::chrono::seconds{options_.broker.keep_alive_s}});
    }

    void on_time_out() {
        if (!was_connected_) return fail(options_.broker.unreachable(client_->was_refused()));
        finish(timed_out);
    }

    /// Says goodbye; the end comes with Disconnected.
    void finish(int exit_code) {
        if (finishing_) return;
        finishing_ = true;
        exit_code_ = exit_code;
        if (!client_->core().is_connected()) return io_.stop();
        client_->disconnect();
        // A broker that is there answers in a moment; nobody waits for one that is not.
        timeout_.expires_after(300ms);
        timeout_.async_wait([this](const auto& stopped) {
            if (!stopped) io_.stop();
        });
    }

    void fail(std::string sentence) {
        error_ = std::move(sentence);
        if (client_->core().is_connected()) client_->disconnect();
        io_.stop();
    }

    void fail_to_subscribe(mqttsn::ReturnCode code) {
        fail("the broker at " + options_.broker.where() +
             " refused a subscription: " + words_for(code));
    }

    void on_event(const client::Event& event) {
        if (std::holds_alternative<client::Connected>(event)) {
            was_connected_ = true;
            for (const mqttsn::TopicRef& topic : topics_) {
                (void)client_->subscribe(topic, static_cast<mqttsn::Qos>(options_.qos));
            }
        } else if (const auto* received = std::get_if<client::Received>(&event)) {
            print(*received);
        } else if (const auto* failed = std::get_if<client::Failed>(&event)) {
            fail_to_subscribe(failed->return_code);
        } else if (std::holds_alternative<client::Congested>(event)) {
            fail_to_subscribe(mqttsn::ReturnCode::congestion);
        } else if (const auto* refused = std::get_if<client::Refused>(&event)) {
            fail("the broker at " + options_.broker.where() +
                 " refused the connection: " + words_for(refused->return_code));
        } else if (const auto* ended = std::get_if<client::Disconnected>(&event)) {
            if (finishing_ || !ended->by_broker) {
                io_.stop();
            } else {
                connect_again("the broker ended the connection");
            }
        } else if (std::holds_alternative<client::Lost>(event)) {
            if (finishing_) return io_.stop();
            if (!was_connected_) return fail(options_.broker.unreachable(client_->was_refused()));
            connect_again("the broker does not answer");
        }
    }

    void connect_again(const char* reason) {
        std::fprintf(stderr, "romano sub: %s; connecting again\n", reason);
        connect();
    }

    void print(const client::Received& message) {
        if (finishing_ || (message.retain && options_.no_retained)) return;
        const std::string text = options_.as_json ? json_of(message) : line_of(message);
        std::fwrite(text.data(), 1, text.size(), stdout);
        std::fputc('\n', stdout);
        std::fflush(stdout);
        if (++printed_ == options_.count) finish(0);
    }

    [[nodiscard]] std::string line_of(const client::Received& message) const {
        std::string line;
        if (options_.verbose) {
            line = message.topic.type == mqttsn::TopicIdType::predefined
                       ? "predefined:" + std::to_string(static_cast<int>(message.topic.id))
                       : std::string{message.topic.name};
            line += ' ';
        }
        const auto romano =
            options_.raw ? std::nullopt : romano_message(message.topic.name, message.data);
        return line + (romano ? to_line(*romano) : std::string{as_text(message.data)});
    }

    static std::string json_of(const client::Received& message) {
        nlohmann::ordered_json out;
        if (message.topic.type == mqttsn::TopicIdType::predefined) {
            out["predefined"] = static_cast<int>(message.topic.id);
        } else {
            out["topic"] = message.topic.name;
        }
        out["qos"] = static_cast<int>(message.qos);
        out["retain"] = message.retain;
        if (const auto romano = romano_message(message.topic.name, message.data)) {
            out["romano"] = to_json(*romano);
        } else if (is_text(message.data)) {
            out["text"] = as_text(message.data);
        } else {
            out["octets"] = hexadecimal(message.data);
        }
        return out.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    }

    const SubOptions& options_;
    std::string client_id_;
    std::vector<mqttsn::TopicRef> topics_;
    boost::asio::io_context io_{1};
    boost::asio::signal_set interrupts_;
    boost::asio::steady_timer timeout_;
    bool was_connected_ = false;
    bool finishing_ = false;
    std::uint64_t printed_ = 0;
    int exit_code_ = 0;
    std::string error_;
    std::unique_ptr<WatcherClient> client_;
};

}  // namespace

void add_sub(CLI::App& program, int& exit_code) {
    auto options = std::make_shared<SubOptions>();
    CLI::App& command = *program.add_subcommand("sub", "Subscribe and print what arrives");
    options->broker.add_to(command);
    options->broker.add_key_to(command);
    command.add_option("-t,--topic", options->topics, "A topic filter; may be given several times")
        ->allow_extra_args(false);
    command
        .add_option("--predefined", options->predefined,
                    "A predefined topic id (1 to 65534); may be given several times")
        ->check(CLI::Range(1, 65534))
        ->allow_extra_args(false);
    command.add_option("-q,--qos", options->qos, "Receive at 0, 1 or 2 at most")
        ->check(CLI::Range(0, 2))
        ->capture_default_str();
    command.add_flag("-c,--keep-session", options->keep_session,
                     "Not a clean session: the broker keeps it, and messages, for the next time");
    command.add_flag("-v,--verbose", options->verbose, "Print the topic before each message");
    command.add_flag("-R,--no-retained", options->no_retained, "Leave out retained messages");
    CLI::Option* raw = command.add_flag(
        "--raw", options->raw, "Print the octets as they came; else ROMANO messages in words");
    command
        .add_flag("--json", options->as_json,
                  "Print a JSON object a line: topic, qos, retain, and romano, text or octets")
        ->excludes(raw);
    command.add_option("-C,--count", options->count, "End after so many messages");
    command.add_option("-W,--timeout", options->timeout_s, "End after so many seconds")
        ->check(real_number(0.0, 1e9));
    command.footer(sub_examples);
    command.callback([options, &exit_code] {
        if (options->topics.empty() && options->predefined.empty()) {
            throw CommandError("a topic is needed: -t FILTER or --predefined ID");
        }
        for (const std::string& filter : options->topics) {
            if (mqttsn::is_valid_topic_filter(filter)) continue;
            throw CommandError("-t `" + filter +
                               "`: must be UTF-8 and not empty, with + as a whole level and # as "
                               "the last one");
        }
        if (options->keep_session && options->broker.client_id.empty()) {
            throw CommandError("-c needs -i ID: a session is kept under its client's id");
        }
        exit_code = Subscriber{*options}.run();
    });
}

}  // namespace romano::experiments
