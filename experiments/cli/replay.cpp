#include "experiments/cli/replay.h"

#include <unistd.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <chrono>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include "broker/net/clock.h"
#include "experiments/cli/broker_options.h"
#include "experiments/cli/denial.h"
#include "experiments/cli/interrupt.h"
#include "experiments/mcap/reader.h"
#include "experiments/recording/left_out_text.h"
#include "experiments/recording/recorded_message.h"
#include "experiments/recording/recording_file.h"
#include "romano/cli/real_number.h"
#include "romano/mqttsn/topic.h"

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;
using Seconds = std::chrono::duration<double>;

constexpr const char* replay_examples = R"(Examples:
  romano replay tuesday.mcap                       (at the times at which it was recorded)
  romano replay tuesday.mcap --speed 20 --topics 'robots/#' -h 127.0.0.2
  romano replay tuesday.mcap --from 60 --for 10 --qos 0 --no-retain
  romano replay tuesday.mcap --steer               (commands too: ROBOTS MOVE)

Robots and brokers act on some messages: movements, what is said to a robot on its own topic, on
common and init-info. Without --steer these are left out and counted. What brokers themselves say
($SYS, $ROMANO) is never replayed.
)";

struct ReplayOptions {
    BrokerOptions broker;
    std::string file;
    double speed = 1;
    std::vector<std::string> filters;
    std::optional<int> qos;
    bool no_retain = false;
    bool steers = false;
    double from_s = 0;
    double for_s = 0;
    bool as_json = false;
};

/// What became of the recording's messages.
struct ReplayCount {
    std::uint64_t published = 0;
    std::uint64_t held_back = 0;  // that robots or brokers heed
    std::uint64_t of_brokers = 0;
    std::uint64_t not_asked_for = 0;  // --topics
    std::uint64_t foreign = 0;        // not as romano record writes them
    std::uint64_t refused = 0;        // by the broker, or too long for a datagram
    Duration latest{};                // behind the time that --speed gives
};

class Replay {
public:
    explicit Replay(const ReplayOptions& options)
        : options_(options),
          file_(RecordingFile::open(options.file)),
          reader_(file_),
          client_id_(options.broker.id_or("romano-replay")) {
        if (!reader_.is_mcap()) {
            throw CommandError("`" + options.file + "` is no recording: it does not begin as MCAP");
        }
        begin_ = reader_.start() + nanoseconds(options.from_s);
        end_ = options.for_s > 0 ? begin_ + nanoseconds(options.for_s) : reader_.end();
        client_ = std::make_unique<WatcherClient>(
            io_, resolve_broker(io_, options.broker.host, options.broker.port),
            options.broker.timing(), static_cast<std::uint64_t>(::getpid()),
            [this](const client::Event& event) { on_event(event); }, options.broker.packets());
    }

    void run() {
        client_->connect({.client_id = client_id_,
                          .clean_session = true,
                          .keep_alive = std::chrono::seconds{options_.broker.keep_alive_s}});
        wait_until([this] { return client_->core().is_connected(); });
        if (options_.from_s > 0) reader_.seek(begin_);
        started_ = net::now();
        while (const auto told = reader_.next()) {
            if (told->time > end_ || interrupt_.has_come()) break;
            replay(*told);
        }
        if (!interrupt_.has_come()) wait_until([this] { return client_->core().is_idle(); });
        client_->disconnect();
        is_leaving_ = true;
        wait_until([this] { return has_left_; });
        tell_the_end();
    }

private:
    [[nodiscard]] static mcap::Timestamp nanoseconds(double seconds) {
        return static_cast<mcap::Timestamp>(seconds * 1e9);
    }

    void replay(const mcap::Reader::Told& told) {
        const auto message = recorded_message(*told.channel, told.data);
        if (!message) {
            ++count_.foreign;
            return;
        }
        if (!is_wanted(*message)) return;
        const Duration since = std::chrono::duration_cast<Duration>(Seconds{
            static_cast<double>(told.time - std::min(begin_, told.time)) / 1e9 / options_.speed});
        const Instant due = started_ + since;
        wait_until([&] { return net::now() >= due; });
        publish(*message);
        count_.latest = std::max(count_.latest, net::now() - due);
    }

    [[nodiscard]] bool is_wanted(const RecordedMessage& message) {
        if (message.kind == recorder_kind || message.topic.starts_with('$')) {
            ++count_.of_brokers;
            return false;
        }
        const auto asks_for_it = [&](const std::string& filter) {
            return mqttsn::matches(filter, message.topic);
        };
        if (!options_.filters.empty() && std::ranges::none_of(options_.filters, asks_for_it)) {
            ++count_.not_asked_for;
            return false;
        }
        if (!options_.steers && is_heeded(message.topic, as_octets(message.data))) {
            ++count_.held_back;
            return false;
        }
        return true;
    }

    void publish(const RecordedMessage& message) {
        const std::optional<mqttsn::TopicRef> topic = topic_of(message);
        if (!topic) {
            ++count_.foreign;
            return;
        }
        const client::PublishOptions how{
            .qos = options_.qos ? static_cast<mqttsn::Qos>(*options_.qos) : message.qos,
            .retain = message.retain && !options_.no_retain};
        bool is_first = true;
        while (!interrupt_.has_come()) {
            const auto begun = client_->publish(*topic, as_octets(message.data), how);
            if (begun) break;
            // The broker has not taken yet what waits for it; what alone is too long never goes.
            const bool waits = begun.error() == client::Refusal::queue_full &&
                               (is_first || !client_->core().is_idle());
            is_first = false;
            if (!waits) {
                ++count_.refused;
                return;
            }
            const std::size_t ended = ended_;
            wait_until([&] { return ended_ != ended || client_->core().is_idle(); });
        }
        ++count_.published;
        io_.poll();
        heed_trouble();
    }

    [[nodiscard]] static std::optional<mqttsn::TopicRef> topic_of(const RecordedMessage& message) {
        if (message.kind == "short") {
            if (message.topic.empty() || message.topic.size() > 2) return std::nullopt;
            return client::short_topic(message.topic);
        }
        if (message.kind == "predefined") {
            unsigned id = 0;
            for (const char c : message.topic) {
                if (c < '0' || c > '9' || id > 65'535) return std::nullopt;
                id = id * 10 + static_cast<unsigned>(c - '0');
            }
            if (id == 0 || id > 65'534) return std::nullopt;
            return client::predefined_topic(mqttsn::TopicId{static_cast<std::uint16_t>(id)});
        }
        if (message.kind != "name" || !mqttsn::is_valid_topic_name(message.topic)) {
            return std::nullopt;
        }
        return client::topic_name(message.topic);
    }

    template <typename Done>
    void wait_until(const Done& is_done) {
        while (!is_done() && !(interrupt_.has_come() && !is_leaving_)) {
            io_.run_one_for(1ms);
            heed_trouble();
            tell();
        }
    }

    void heed_trouble() {
        if (error_.empty()) return;
        throw CommandError(error_ + ", after " + std::to_string(count_.published) +
                           " messages of the recording");
    }

    void on_event(const client::Event& event) {
        if (std::holds_alternative<client::Published>(event)) {
            ++ended_;
        } else if (std::holds_alternative<client::Failed>(event)) {
            ++ended_;
            ++count_.refused;
            --count_.published;
        } else if (std::holds_alternative<client::Disconnected>(event)) {
            has_left_ = true;
            if (!is_leaving_)
                error_ = "the broker at " + options_.broker.where() + " ended the connection";
        } else if (std::holds_alternative<client::Lost>(event)) {
            has_left_ = true;
            if (!is_leaving_) error_ = options_.broker.unreachable(client_->was_refused());
        } else if (const auto* refused = std::get_if<client::Refused>(&event)) {
            error_ = "the broker at " + options_.broker.where() +
                     " refused the connection: " + words_for(refused->return_code);
        }
    }

    void tell() {
        const Instant now = net::now();
        if (::isatty(STDERR_FILENO) == 0 || now < tell_due_) return;
        tell_due_ = now + 1s;
        const double length = static_cast<double>(end_ - std::min(begin_, end_)) / 1e9;
        const double at = Seconds{now - started_}.count() * options_.speed;
        std::fprintf(stderr, "\r%.0f of %.0f s, %llu messages ", std::min(at, length), length,
                     static_cast<unsigned long long>(count_.published));
    }

    void tell_the_end() const {
        if (::isatty(STDERR_FILENO) != 0) std::fputc('\n', stderr);
        const double late_s = Seconds{count_.latest}.count();
        const auto sentences = sentences_about(reader_);
        if (options_.as_json) {
            const nlohmann::ordered_json object{{"published", count_.published},
                                                {"held_back", count_.held_back},
                                                {"of_brokers", count_.of_brokers},
                                                {"not_asked_for", count_.not_asked_for},
                                                {"foreign", count_.foreign},
                                                {"refused", count_.refused},
                                                {"latest_s", late_s},
                                                {"lost", sentences}};
            std::puts(
                object.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace).c_str());
            return;
        }
        std::printf("%llu messages were published\n",
                    static_cast<unsigned long long>(count_.published));
        const auto note = [](std::uint64_t count, const char* words) {
            if (count > 0)
                std::fprintf(stderr, "%llu %s\n", static_cast<unsigned long long>(count), words);
        };
        note(count_.held_back,
             "that robots or brokers act on were held back (--steer replays them: robots move)");
        note(count_.foreign, "were not written by romano record, and left out");
        note(count_.refused, "were refused by the broker, or are too long for one datagram");
        if (late_s > 0.1) {
            std::fprintf(stderr,
                         "the last of them came up to %.1f s late: the broker took them more "
                         "slowly than at --speed %g\n",
                         late_s, options_.speed);
        }
        for (const std::string& sentence : sentences) {
            std::fprintf(stderr, "%s: %s\n", options_.file.c_str(), sentence.c_str());
        }
    }

    const ReplayOptions& options_;
    boost::asio::io_context io_{1};
    const Interrupt interrupt_{io_};
    RecordingFile file_;
    mcap::Reader reader_;
    std::string client_id_;
    std::unique_ptr<WatcherClient> client_;
    mcap::Timestamp begin_ = 0;
    mcap::Timestamp end_ = 0;
    Instant started_{};
    Instant tell_due_{};
    ReplayCount count_;
    std::size_t ended_ = 0;  // operations
    bool is_leaving_ = false;
    bool has_left_ = false;
    std::string error_;
};

}  // namespace

void add_replay(CLI::App& program, int& exit_code) {
    auto options = std::make_shared<ReplayOptions>();
    CLI::App& command = *program.add_subcommand(
        "replay", "Publish once more what romano record wrote down, at its times");
    options->broker.add_to(command);
    options->broker.add_key_to(command);
    command.add_option("file", options->file, "The recording")->required()->type_name("FILE");
    command.add_option("--speed", options->speed, "So many times as fast, 0.1 to 100")
        ->check(real_number(0.1, 100.0))
        ->capture_default_str();
    command.add_option("--topics", options->filters, "Only these (repeatable); default: all")
        ->type_name("FILTER");
    command.add_option("-q,--qos", options->qos, "At this QoS; default: as each was recorded")
        ->check(CLI::Range(0, 2));
    command.add_flag("--no-retain", options->no_retain,
                     "The broker keeps none, also not of those that it had kept");
    command.add_flag("--steer", options->steers,
                     "Messages that robots and brokers act on too: ROBOTS MOVE");
    command.add_option("--from", options->from_s, "Begin so many seconds after the beginning")
        ->type_name("SECONDS")
        ->check(real_number(0.0, 1e9))
        ->capture_default_str();
    command.add_option("--for", options->for_s, "So many seconds of it; 0: to its end")
        ->type_name("SECONDS")
        ->check(real_number(0.0, 1e9))
        ->capture_default_str();
    command.add_flag("--json", options->as_json, "Say in the end what became of it, as JSON");
    command.footer(replay_examples);
    command.callback([options, &exit_code] {
        check_filters(options->filters);
        Replay{*options}.run();
        exit_code = 0;
    });
}

}  // namespace romano::experiments
