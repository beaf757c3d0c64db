#include "experiments/cli/record.h"

#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "broker/net/clock.h"
#include "experiments/cli/broker_options.h"
#include "experiments/cli/denial.h"
#include "experiments/cli/interrupt.h"
#include "experiments/recording/recorder.h"
#include "experiments/sweep/build_info.h"
#include "experiments/watch/broker_status.h"
#include "romano/cli/real_number.h"
#include "romano/mqttsn/topic.h"
#include "romano/server/server.h"

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;

constexpr const char* record_examples = R"(Examples:
  romano record tuesday.mcap                  (until Ctrl-C; then: romano replay tuesday.mcap)
  romano record run.mcap --for 60 -h 127.0.0.2
  romano record poses.mcap --topics 'robots/+/pose' --qos 0

The file is MCAP: Foxglove, PlotJuggler and the mcap tools open it. What stands in it is there
after a kill too, but for the last second.
)";

struct RecordOptions {
    BrokerOptions broker;
    std::string file;
    std::vector<std::string> filters = {"#"};
    int qos = 2;
    double for_s = 0;
    bool as_json = false;
};

class Recording {
public:
    explicit Recording(const RecordOptions& options)
        : options_(options),
          broker_(resolve_broker(io_, options.broker.host, options.broker.port)),
          packets_(options.broker.packets()),
          file_(RecordingFile::create(options.file)),
          recorder_(io_,
                    {.broker = broker_,
                     .broker_name = options.broker.where(),
                     .client_id = options.broker.id_or("romano-record"),
                     .timing = options.broker.timing(),
                     .keep_alive = client::KeepAlive{options.broker.keep_alive_s},
                     .packets = packets_,
                     .filters = all_filters(),
                     .qos = static_cast<mqttsn::Qos>(options.qos)},
                    file_, "romano " + build_info().version) {}

    void run() {
        const Instant begin = net::now();
        const auto is_over = [&] {
            return options_.for_s > 0 &&
                   net::now() - begin >= std::chrono::duration<double>{options_.for_s};
        };
        while (!interrupt_.has_come() && !is_over() && recorder_.disk_trouble().empty()) {
            io_.run_one_for(100ms);
            if (!recorder_.has_begun() && (recorder_.has_failed() || recorder_.denial())) {
                (void)::unlink(options_.file.c_str());
                throw CommandError(
                    why_not(options_.broker, recorder_.denial(), recorder_.was_refused()));
            }
            if (recorder_.subscription_denial()) {
                (void)::unlink(options_.file.c_str());
                throw CommandError(
                    "the broker at " + options_.broker.where() +
                    " refused a subscription: " + words_for(*recorder_.subscription_denial()));
            }
            tell();
        }
        recorder_.finish();
        io_.poll();
        tell_the_end();
    }

private:
    [[nodiscard]] std::vector<std::string> all_filters() const {
        std::vector<std::string> filters = options_.filters;
        // What the page of a recording needs; # does not match names that begin with $.
        filters.emplace_back(brokers_filter);
        filters.emplace_back(server::entries_filter);
        return filters;
    }

    void tell() {
        if (!recorder_.has_begun()) return;
        if (!is_told_) {
            std::fprintf(stderr, "recording into %s; Ctrl-C ends it\n", options_.file.c_str());
            is_told_ = true;
        }
        if (was_linked_ != recorder_.is_linked()) {
            was_linked_ = recorder_.is_linked();
            std::fprintf(stderr, was_linked_ ? "the broker answers again\n"
                                             : "the broker does not answer; it is asked again\n");
        }
        const Instant now = net::now();
        if (::isatty(STDERR_FILENO) == 0 || now < tell_due_) return;
        tell_due_ = now + 1s;
        std::fprintf(stderr, "\r%llu messages, %.1f MB ",
                     static_cast<unsigned long long>(recorder_.messages()),
                     static_cast<double>(file_.size()) / 1e6);
    }

    void tell_the_end() const {
        const auto count = [](std::uint64_t number) {
            return static_cast<unsigned long long>(number);
        };
        if (::isatty(STDERR_FILENO) != 0) std::fputc('\n', stderr);
        if (options_.as_json) {
            const nlohmann::ordered_json object{{"file", options_.file},
                                                {"messages", recorder_.messages()},
                                                {"octets", file_.size()},
                                                {"dropped", recorder_.dropped()},
                                                {"is_finished", recorder_.is_finished()}};
            std::puts(
                object.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace).c_str());
        } else {
            std::printf("%s: %llu messages, %.1f MB\n", options_.file.c_str(),
                        count(recorder_.messages()), static_cast<double>(file_.size()) / 1e6);
        }
        std::fflush(stdout);
        if (!recorder_.disk_trouble().empty()) {
            throw CommandError(recorder_.disk_trouble() + ": what came before is in it (" +
                               std::to_string(recorder_.messages()) + " messages)");
        }
        if (recorder_.dropped() > 0) {
            std::fprintf(stderr,
                         "%llu messages are not in it: there are too many topics; --topics takes "
                         "fewer\n",
                         count(recorder_.dropped()));
        }
    }

    const RecordOptions& options_;
    boost::asio::io_context io_{1};
    const Interrupt interrupt_{io_};
    BrokerAddress broker_;
    std::shared_ptr<keys::ClientPackets> packets_;
    RecordingFile file_;
    Recorder recorder_;
    bool is_told_ = false;
    bool was_linked_ = true;
    Instant tell_due_{};
};

}  // namespace

void add_record(CLI::App& program, int& exit_code) {
    auto options = std::make_shared<RecordOptions>();
    CLI::App& command = *program.add_subcommand(
        "record", "Write all that goes over the brokers into a file (MCAP)");
    options->broker.add_to(command);
    options->broker.add_key_to(command);
    command.add_option("file", options->file, "The file; one that is there is refused")
        ->required()
        ->type_name("FILE");
    command
        .add_option("--topics", options->filters,
                    "What is recorded beside the brokers' and robots' states (repeatable)")
        ->type_name("FILTER")
        ->capture_default_str();
    command
        .add_option("-q,--qos", options->qos,
                    "Receive at 0, 1 or 2 at most; a replay publishes at what was received")
        ->check(CLI::Range(0, 2))
        ->capture_default_str();
    command.add_option("--for", options->for_s, "End after so many seconds; 0: with Ctrl-C")
        ->type_name("SECONDS")
        ->check(real_number(0.0, 1e9))
        ->capture_default_str();
    command.add_flag("--json", options->as_json, "Say in the end what is in it as a JSON object");
    command.footer(record_examples);
    command.callback([options, &exit_code] {
        std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is told of like a full disk
        check_filters(options->filters);
        Recording{*options}.run();
        exit_code = 0;
    });
}

}  // namespace romano::experiments
