#include "experiments/recording/recorder.h"

#include <chrono>
#include <functional>
#include <utility>
#include <variant>

#include "broker/net/clock.h"
#include "experiments/mcap/summary.h"
#include "experiments/recording/recorded_message.h"

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;

constexpr auto look_every = 100ms;
constexpr auto ask_again_after = 1s;

}  // namespace

Recorder::Recorder(boost::asio::io_context& io, RecorderOptions options, RecordingFile& file,
                   std::string library)
    : io_(io),
      options_(std::move(options)),
      file_(file),
      writer_(recording_schema(), std::string{recording_encoding}),
      timer_(io),
      unix_time_at_zero_(net::unix_time_at_zero()) {
    file_.append(writer_.beginning(library));
    connect();
    tick();
}

void Recorder::connect() {
    connect_due_.reset();
    failed_ = false;
    old_client_ = std::move(client_);
    client_ = std::make_unique<WatcherClient>(
        io_, options_.broker, options_.timing, std::hash<std::string>{}(options_.client_id),
        [this, life = ++life_](const client::Event& event) {
            if (life == life_) on_event(event);
        },
        options_.packets);
    client_->connect({.client_id = options_.client_id,
                      .clean_session = true,
                      .keep_alive = options_.keep_alive});
}

void Recorder::on_event(const client::Event& event) {
    if (is_over_) return;
    if (std::holds_alternative<client::Connected>(event)) {
        has_begun_ = true;
        denial_.reset();
        set_link(true);
        for (const std::string& filter : options_.filters) {
            (void)client_->subscribe(client::topic_name(filter), options_.qos);
        }
    } else if (const auto* received = std::get_if<client::Received>(&event)) {
        const RecordedTopic topic = recorded_topic(received->topic);
        write(topic.topic, topic.kind,
              recorded_text(topic.topic, received->data, received->qos, received->retain));
    } else if (const auto* refused = std::get_if<client::Refused>(&event)) {
        denial_ = refused->return_code;
        lose();
    } else if (const auto* denied = std::get_if<client::Failed>(&event)) {
        subscription_denial_ = denied->return_code;
    } else if (std::holds_alternative<client::Lost>(event) ||
               std::holds_alternative<client::Disconnected>(event)) {
        lose();
    }
}

void Recorder::set_link(bool is_linked) {
    if (std::exchange(is_linked_, is_linked) == is_linked) return;
    write(recorder_topic, recorder_kind, recorded_link(is_linked, options_.broker_name));
}

void Recorder::lose() {
    failed_ = true;
    set_link(false);
    connect_due_ = net::now() + ask_again_after;
}

void Recorder::write(std::string_view topic, std::string_view kind, const std::string& text) {
    const Instant now = net::now();
    const auto time = static_cast<mcap::Timestamp>(
        std::chrono::nanoseconds{now.time_since_epoch() + unix_time_at_zero_}.count());
    if (!disk_trouble_.empty() || !writer_.add(time, topic, kind, as_octets(text))) {
        ++dropped_;
        return;
    }
    ++messages_;
    ++unwritten_;
    if (!flush_due_) flush_due_ = now + chunk_at_least_every;
    if (writer_.waiting() >= chunk_octets) flush();
}

void Recorder::flush() {
    flush_due_.reset();
    const mcap::Octets chunk = writer_.take_chunk();
    try {
        if (disk_trouble_.empty()) file_.append(chunk);
    } catch (const RecordingError& error) {
        disk_trouble_ = error.what();
        messages_ -= unwritten_;
        dropped_ += unwritten_;
    }
    unwritten_ = 0;
}

void Recorder::tick() {
    const Instant now = net::now();
    if (connect_due_ && now >= *connect_due_) connect();
    if (flush_due_ && now >= *flush_due_) flush();
    timer_.expires_after(look_every);
    timer_.async_wait([this](const boost::system::error_code& stopped) {
        if (!stopped) tick();
    });
}

void Recorder::finish() {
    is_over_ = true;
    timer_.cancel();
    client_->disconnect();
    if (disk_trouble_.empty()) flush();
    const std::uint64_t data_octets = file_.size();
    const auto append = [this](Bytes part) {
        try {
            file_.append(part);
        } catch (const RecordingError& error) {
            if (disk_trouble_.empty()) disk_trouble_ = error.what();
            return false;
        }
        return true;
    };
    is_finished_ = mcap::append_summary(file_, append);
    if (!is_finished_) file_.cut_back_to(data_octets);
}

}  // namespace romano::experiments
