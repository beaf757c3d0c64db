// The MQTT-SN clients of a load: one client core each, with room for what the plan needs of it, on
// batched sockets. Only standard messages, so any broker or gateway may be at the other end.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "broker/core/deadlines.h"
#include "experiments/load/client_sockets.h"
#include "experiments/load/load_client.h"
#include "experiments/load/load_clients.h"
#include "experiments/load/load_plan.h"
#include "romano/base/endpoint.h"
#include "romano/client/client.h"
#include "romano/keys/client_speech.h"

namespace romano::experiments {

/// A client with a key.
struct KeyedClient {
    std::string client_id;
    std::unique_ptr<keys::ClientSpeech> speech;
};

struct MqttsnOptions {
    /// Publisher i lives at brokers[i mod N], subscriber i at brokers[i + 1 mod N].
    std::vector<Endpoint> brokers;
    /// Publishers live at so many of the first brokers only; empty: at all.
    std::optional<std::size_t> publishers_at = {};
    SocketUse sockets = SocketUse::one_each;
    client::Timing timing;
    std::chrono::seconds keep_alive{60};
    std::string id_prefix = "load";
    /// Subscribers listen there, too (romano/mqttsn/cell.md); or family none.
    Endpoint cell_group = {};
    /// Makes client i; empty: all speak plain, and their names begin with the prefix.
    std::function<KeyedClient(std::uint32_t client, keys::ClientSpeech::Put put)> keyed = {};
};

class MqttsnClients : public LoadClients, private ClientSockets::Listener {
public:
    /// Throws std::runtime_error with a sentence.
    MqttsnClients(const LoadPlan& plan, const MqttsnOptions& options);
    ~MqttsnClients() override;

    void attach(LoadClients::Listener& listener) override { listener_ = &listener; }
    void join(Number client) override;
    std::optional<PublishId> publish(Instant now, Number client, std::uint32_t topic,
                                     Bytes payload) override;
    void turn(Instant until) override;
    void leave() override;
    [[nodiscard]] std::uint64_t retransmissions() const override { return retransmissions_; }
    [[nodiscard]] std::uint64_t dropped_here() const override {
        return sockets_.dropped() + sockets_.not_sent();
    }
    [[nodiscard]] std::optional<std::uint64_t> heard_in_cell() const override {
        if (!has_cell()) return std::nullopt;
        return sockets_.heard_in_cell();
    }

    /// A datagram that is nobody's, from the address of that client; numbers beyond the clients are
    /// addresses of strangers. With a shared socket alone.
    void forge(Number from, Bytes datagram) { sockets_.queue(from, datagram); }

private:
    void send(Number number, Bytes message);
    void expect(Number client) override;
    void on_datagram(Instant now, Number client, Bytes octets) override;
    void on_event(Number number, const client::Event& event);
    void go_on_joining(Number number);
    [[nodiscard]] bool has_cell() const {
        return options_.cell_group.family != Endpoint::Family::none;
    }
    [[nodiscard]] std::optional<ListenedCell> cell() const {
        if (!has_cell()) return std::nullopt;
        return ListenedCell{options_.cell_group, plan_.publishers};
    }
    [[nodiscard]] std::uint8_t* room_of(Number number) {
        return rooms_.data() + number * layout_.octets();
    }
    void drain(Number number);
    void tick(Instant now);
    [[nodiscard]] std::string loss(Number number) const;

    const LoadPlan& plan_;
    MqttsnOptions options_;
    ClientSockets sockets_;
    std::vector<std::string> topic_names_;
    ClientLayout layout_;
    std::vector<std::uint8_t> rooms_;  // of all clients, one behind the other
    std::deque<LoadClient> clients_;
    std::vector<std::unique_ptr<keys::ClientSpeech>> speeches_;  // by client; none: plain
    broker::Deadlines deadlines_;
    LoadClients::Listener* listener_ = nullptr;
    Instant now_{};  // of this turn
    std::uint64_t retransmissions_ = 0;
};

}  // namespace romano::experiments
