// Writes down all that one broker delivers, as a plain MQTT-SN client that hears everything. When
// the broker does not answer any more, that is written down too, and it is asked again each second.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "experiments/mcap/chunk_writer.h"
#include "experiments/recording/recording_file.h"
#include "experiments/robots/socket_client.h"

namespace romano::experiments {

struct RecorderOptions {
    BrokerAddress broker;
    std::string broker_name;  // for people
    std::string client_id;
    client::Timing timing;
    client::KeepAlive keep_alive{60};
    std::shared_ptr<keys::ClientPackets> packets;
    std::vector<std::string> filters;
    mqttsn::Qos qos = mqttsn::Qos::exactly_once;  // at most
};

class Recorder {
public:
    /// What a kill costs at most, in time and in octets before compression.
    static constexpr std::chrono::seconds chunk_at_least_every{1};
    static constexpr std::size_t chunk_octets = 1UL << 20U;

    /// `file`: an empty one.
    Recorder(boost::asio::io_context& io, RecorderOptions options, RecordingFile& file,
             std::string library);

    /// Hears nothing more, and ends the file as it should be.
    void finish();

    [[nodiscard]] bool has_begun() const { return has_begun_; }
    [[nodiscard]] bool is_linked() const { return is_linked_; }
    /// No answer after all repetitions, or a refusal.
    [[nodiscard]] bool has_failed() const { return failed_; }
    [[nodiscard]] std::optional<mqttsn::ReturnCode> denial() const { return denial_; }
    /// It does not hear all that it should.
    [[nodiscard]] std::optional<mqttsn::ReturnCode> subscription_denial() const {
        return subscription_denial_;
    }
    [[nodiscard]] bool was_refused() const { return client_->was_refused(); }
    /// Why nothing more can be written; empty while it can.
    [[nodiscard]] const std::string& disk_trouble() const { return disk_trouble_; }

    /// finish() wrote the end. Without it, as after a kill, readers go through the whole file.
    [[nodiscard]] bool is_finished() const { return is_finished_; }

    [[nodiscard]] std::uint64_t messages() const { return messages_; }
    /// Not in the file: there were too many topics, or the disk was full.
    [[nodiscard]] std::uint64_t dropped() const { return dropped_; }

private:
    void connect();
    void on_event(const client::Event& event);
    void set_link(bool is_linked);
    void lose();
    void write(std::string_view topic, std::string_view kind, const std::string& text);
    void tick();
    void flush();

    boost::asio::io_context& io_;
    RecorderOptions options_;
    RecordingFile& file_;
    mcap::ChunkWriter writer_;
    boost::asio::steady_timer timer_;
    std::unique_ptr<WatcherClient> client_;
    std::unique_ptr<WatcherClient> old_client_;  // a timer of its own may be about to call it
    unsigned life_ = 0;                          // of the client
    Duration unix_time_at_zero_;
    std::optional<Instant> connect_due_;
    std::optional<Instant> flush_due_;
    bool has_begun_ = false;
    bool is_linked_ = false;
    bool failed_ = false;
    bool is_over_ = false;
    bool is_finished_ = false;
    std::optional<mqttsn::ReturnCode> denial_;
    std::optional<mqttsn::ReturnCode> subscription_denial_;
    std::string disk_trouble_;
    std::uint64_t messages_ = 0;
    std::uint64_t unwritten_ = 0;  // of messages_, in the chunk that is not in the file yet
    std::uint64_t dropped_ = 0;
};

}  // namespace romano::experiments
