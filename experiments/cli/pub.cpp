#include "experiments/cli/pub.h"

#include <poll.h>
#include <unistd.h>

#include <array>
#include <boost/asio/io_context.hpp>
#include <cerrno>
#include <chrono>
#include <deque>
#include <fstream>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "experiments/cli/broker_options.h"
#include "experiments/cli/denial.h"
#include "experiments/cli/interrupt.h"
#include "romano/cli/real_number.h"
#include "romano/mqttsn/topic.h"

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;

constexpr const char* pub_examples = R"(Examples:
  romano pub -t robots/7/command -m "forward 10"
  romano pub -h fe80::1%wlan0 -p 1884 -t map/tile -f tile.bin -q 2 -r
  romano pub -t map/tile -n -r                      (deletes the retained message)
  some-sensor | romano pub -t sensors/a -l -q 1     (each line is a message)
  romano pub --predefined 3 -m 1 -q -1              (without a connection)
)";

constexpr const char* no_registration =
    "-q -1 needs a topic without registration: --predefined ID, or --short with a name of two "
    "octets";

struct PubOptions {
    BrokerOptions broker;
    TopicOption topic;
    std::optional<std::string> message;
    std::string file;
    bool empty = false;
    bool lines = false;
    int qos = 0;
    bool retain = false;
    unsigned repeat = 1;
    double repeat_delay_s = 0;
};

/// Lines of standard input as they come, without stopping the client while none does.
class StandardInput {
public:
    [[nodiscard]] bool has_ended() const { return ended_ && lines_.empty(); }

    std::optional<std::string> next_line() {
        if (lines_.empty() && !ended_) read();
        if (lines_.empty()) return std::nullopt;
        std::string line = std::move(lines_.front());
        lines_.pop_front();
        return line;
    }

private:
    void read() {
        pollfd input{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
        if (::poll(&input, 1, 0) <= 0) return;
        std::array<char, 4096> part{};
        const auto size = ::read(STDIN_FILENO, part.data(), part.size());
        if (size < 0 && errno == EINTR) return;
        if (size <= 0) {
            ended_ = true;
            if (!unfinished_.empty()) lines_.push_back(std::move(unfinished_));
            return;
        }
        unfinished_.append(part.data(), static_cast<std::size_t>(size));
        for (std::size_t end = 0; (end = unfinished_.find('\n')) != std::string::npos;) {
            lines_.push_back(unfinished_.substr(0, end));
            unfinished_.erase(0, end + 1);
        }
    }

    std::string unfinished_;
    std::deque<std::string> lines_;
    bool ended_ = false;
};

class Publisher {
public:
    explicit Publisher(const PubOptions& options)
        : options_(options),
          topic_(options.topic.topic()),
          client_id_(options.broker.id_or("romano-pub")),
          client_(
              io_, resolve_broker(io_, options.broker.host, options.broker.port),
              options.broker.timing(), static_cast<std::uint64_t>(::getpid()),
              [this](const client::Event& event) { on_event(event); }, options.broker.packets()) {}

    void run() {
        const std::string message = options_.lines ? "" : whole_message();
        if (options_.qos >= 0) {
            client_.connect({.client_id = client_id_,
                             .clean_session = true,
                             .keep_alive = std::chrono::seconds{options_.broker.keep_alive_s}});
            wait_for([this] { return client_.core().is_connected(); });
        }
        if (options_.lines) {
            StandardInput input;
            while (!input.has_ended()) {
                if (const auto line = input.next_line()) {
                    publish(*line);
                } else {
                    turn();
                }
            }
        } else {
            for (unsigned i = 0; i < options_.repeat; ++i) {
                if (i > 0) pause();
                publish(message);
            }
        }
        if (options_.qos < 0) return;
        client_.disconnect();
        wait_for([this] { return disconnected_; });
    }

private:
    std::string whole_message() const {
        if (options_.empty) return "";
        if (options_.message) return *options_.message;
        std::ifstream stream(options_.file, std::ios::binary);
        std::string text{std::istreambuf_iterator<char>(stream), {}};
        if (!stream) {
            throw CommandError("-f `" + options_.file +
                               "`: cannot be read; give a file that holds the message");
        }
        return text;
    }

    void publish(const std::string& message) {
        io_.poll();  // at QoS 0 and -1 nothing is waited for below
        heed_trouble();
        published_ = false;
        const auto qos = options_.qos < 0 ? mqttsn::Qos::without_connection
                                          : static_cast<mqttsn::Qos>(options_.qos);
        const auto begun =
            client_.publish(topic_, as_octets(message), {.qos = qos, .retain = options_.retain});
        if (!begun) throw CommandError(refusal(begun.error(), message.size()));
        wait_for([this] { return published_; });
    }

    std::string refusal(client::Refusal reason, std::size_t size) const {
        switch (reason) {
            case client::Refusal::too_long:
            case client::Refusal::queue_full:
                return "a message of " + std::to_string(size) +
                       " octets is too long for one datagram";
            case client::Refusal::invalid_topic:
                return options_.topic.words() + ": no topic";
            case client::Refusal::not_connected:
                break;
        }
        return "not connected";
    }

    void pause() {
        const auto until = std::chrono::steady_clock::now() +
                           std::chrono::duration<double>{options_.repeat_delay_s};
        while (std::chrono::steady_clock::now() < until) turn();
    }

    void turn() {
        io_.run_one_for(20ms);
        heed_trouble();
    }

    void heed_trouble() {
        if (error_.empty() && interrupt_.has_come()) {
            error_ = "interrupted before all was published";
        }
        if (error_.empty()) return;
        if (client_.core().is_connected()) client_.disconnect();
        throw CommandError(error_);
    }

    template <typename Done>
    void wait_for(const Done& done) {
        while (!done()) turn();
    }

    std::string refused_message(mqttsn::ReturnCode code) const {
        return "the broker at " + options_.broker.where() + " refused the message on " +
               options_.topic.words() + ": " + words_for(code);
    }

    void on_event(const client::Event& event) {
        if (std::holds_alternative<client::Published>(event)) {
            published_ = true;
        } else if (std::holds_alternative<client::Disconnected>(event)) {
            disconnected_ = true;
            if (std::get<client::Disconnected>(event).by_broker) {
                error_ = "the broker at " + options_.broker.where() + " ended the connection";
            }
        } else if (std::holds_alternative<client::Lost>(event)) {
            error_ = options_.broker.unreachable(client_.was_refused());
        } else if (const auto* refused = std::get_if<client::Refused>(&event)) {
            error_ = "the broker at " + options_.broker.where() +
                     " refused the connection: " + words_for(refused->return_code);
        } else if (const auto* failed = std::get_if<client::Failed>(&event)) {
            error_ = refused_message(failed->return_code);
        } else if (std::holds_alternative<client::Congested>(event)) {
            error_ = refused_message(mqttsn::ReturnCode::congestion);
        }
    }

    const PubOptions& options_;
    mqttsn::TopicRef topic_;
    std::string client_id_;
    boost::asio::io_context io_{1};
    const Interrupt interrupt_{io_};
    bool published_ = false;
    bool disconnected_ = false;
    std::string error_;
    SocketClient client_;
};

void check(const PubOptions& options) {
    const int sources = (options.message ? 1 : 0) + (options.file.empty() ? 0 : 1) +
                        (options.empty ? 1 : 0) + (options.lines ? 1 : 0);
    if (sources != 1) {
        throw CommandError("one message is needed: -m TEXT, -f FILE, -n (empty) or -l (lines)");
    }
    (void)options.topic.topic();
    const bool is_registered = options.topic.predefined == 0 && !options.topic.is_short;
    if (options.qos < 0 && is_registered) throw CommandError(no_registration);
    if (options.qos < 0 && options.broker.speaks_dtls) {
        throw CommandError(
            "-q -1 with --dtls: must be 0, 1 or 2; DTLS begins with a broker's answers, and "
            "nothing at -1 waits for any");
    }
    if (is_registered && !mqttsn::is_valid_topic_name(options.topic.name)) {
        throw CommandError("-t `" + options.topic.name +
                           "`: must be a topic's name: UTF-8, not empty, without + and #");
    }
}

}  // namespace

void add_pub(CLI::App& program, int& exit_code) {
    auto options = std::make_shared<PubOptions>();
    CLI::App& command = *program.add_subcommand("pub", "Publish messages");
    options->broker.add_to(command);
    options->broker.add_key_to(command);
    options->topic.add_to(command, "The topic's name");
    command.add_option("-m,--message", options->message, "The message");
    command.add_option("-f,--file", options->file, "The message is a file's content");
    command.add_flag("-n,--null-message", options->empty, "The message is empty");
    command.add_flag("-l,--stdin-line", options->lines, "Each line of standard input is a message");
    command.add_option("-q,--qos", options->qos, "-1 (without a connection), 0, 1 or 2")
        ->check(CLI::Range(-1, 2))
        ->capture_default_str();
    command.add_flag("-r,--retain", options->retain, "The broker keeps it for later subscribers");
    command.add_option("--repeat", options->repeat, "Publish it so many times")
        ->check(CLI::Range(1U, 1'000'000'000U))
        ->capture_default_str();
    command.add_option("--repeat-delay", options->repeat_delay_s, "Seconds between them")
        ->check(real_number(0.0, 86'400.0))
        ->capture_default_str();
    command.footer(pub_examples);
    command.callback([options, &exit_code] {
        check(*options);
        Publisher{*options}.run();
        exit_code = 0;
    });
}

}  // namespace romano::experiments
