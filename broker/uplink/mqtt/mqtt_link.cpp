#include "broker/uplink/mqtt/mqtt_link.h"

#include <spdlog/spdlog.h>

#include <chrono>
#include <stdexcept>
#include <utility>

#include "broker/net/turn_clock.h"
#include "broker/uplink/mqtt/mqtt_thread.h"

namespace romano::uplink {
namespace {

// What the MQTT broker shall still hear, that we leave, is worth this at the end of the process.
constexpr std::chrono::milliseconds farewell{300};
constexpr std::chrono::seconds opened_again_after{2};

}  // namespace

MqttLink::MqttLink(boost::asio::io_context& io, const MqttSettings& settings, LinkEvents events)
    : io_(io),
      settings_(settings),
      events_(std::move(events)),
      where_(settings.host + ":" + std::to_string(settings.port)),
      pause_(io) {
    const MqttThread usable(io_, settings_, {});  // or it throws, before anything is started
}

MqttLink::~MqttLink() {
    close();
    if (closing_) closing_->wait_until_ended(farewell);
}

void MqttLink::carry_out(const UplinkAction& action) {
    if (std::holds_alternative<OpenLink>(action)) {
        open_or_wait();
    } else if (std::holds_alternative<CloseLink>(action)) {
        close();
    } else if (const auto* message = std::get_if<PublishUp>(&action)) {
        publish(*message);
    } else if (const auto* safe = std::get_if<Acknowledge>(&action)) {
        if (thread_) thread_->acknowledge(safe->token);
    }
}

void MqttLink::open() {
    close();
    is_wanted_ = true;
    on_their_way_.clear();
    const auto thread = std::make_shared<MqttThread>(
        io_, settings_,
        MqttEvents{
            .on_up =
                [this](bool resumed) {
                    spdlog::info("uplink: connected to {}", where_);
                    events_.on_up(resumed);
                },
            .on_down =
                [this](const std::string& why) {
                    spdlog::warn("uplink: no connection to {}: {}", where_, why);
                    events_.on_down();
                },
            .on_answer =
                [this](int packet_id, Answer answer) {
                    const auto found = on_their_way_.find(packet_id);
                    if (found == on_their_way_.end()) return;  // QoS 0
                    const auto position = found->second;
                    on_their_way_.erase(found);
                    events_.on_answer(position, answer);
                },
            .on_message = [this](const FromRemote& message,
                                 std::uint64_t token) { events_.on_message(message, token); }});
    thread->start();
    thread_ = thread;
}

void MqttLink::open_or_wait() {
    try {
        open();
        is_told_ = false;
    } catch (const std::runtime_error& error) {  // a file that was there at the start is not now
        if (!std::exchange(is_told_, true)) {
            spdlog::warn("uplink: no connection to {}, and it is tried again: {}", where_,
                         error.what());
        }
        pause_.expires_after(opened_again_after);
        pause_.async_wait([this](const boost::system::error_code& cancelled) {
            if (!cancelled && is_wanted_) open_or_wait();
        });
    }
}

void MqttLink::close() {
    is_wanted_ = false;
    pause_.cancel();
    if (!thread_) return;
    thread_->stop();
    closing_ = std::exchange(thread_, nullptr);
    spdlog::info("uplink: left {}", where_);
}

void MqttLink::publish(const PublishUp& message) {
    if (!thread_) return;
    const int packet_id = thread_->publish(message);
    if (message.qos == mqttsn::Qos::at_most_once && message.message->position.seq == 0) return;
    if (packet_id == 0) {
        spdlog::warn("uplink: {} does not take a message on {}", where_, message.topic);
        // It never will. Said later: whoever hands it over is not done yet.
        net::post_turn(
            io_, [alive = std::weak_ptr(thread_), this, position = message.message->position] {
                if (!alive.expired()) events_.on_answer(position, Answer::done);
            });
        return;
    }
    on_their_way_.insert_or_assign(packet_id, message.message->position);
}

}  // namespace romano::uplink
