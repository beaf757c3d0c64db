// A broker as an operating system sees it: a process with a clock, sockets and one timer, that can
// be killed, stopped, continued and started again. What runs inside is a subclass's matter.
//
// While stopped its kernel goes on taking datagrams, some of them; afterwards timer and inputs are
// looked at in an order that nobody promises. The same while its core alone stands still, but its
// other threads live on.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <vector>

#include "overlay/cluster/envelope.h"
#include "overlay/sim/client_network.h"
#include "overlay/sim/event_queue.h"
#include "overlay/sim/local_clock.h"
#include "overlay/sim/trace.h"
#include "romano/base/bytes.h"
#include "romano/base/random.h"

namespace romano::sim {

/// How good a machine it is on.
struct Machine {
    std::int64_t drift_ppm_max = 100;             // of its clock, either way
    Duration turn{std::chrono::milliseconds{1}};  // what a tick takes at least
};

class BrokerProcess {
public:
    BrokerProcess(std::string name, Node node, EventQueue& events, ClientNetwork& clients,
                  Trace& trace, std::uint64_t seed, const Machine& machine = {});
    virtual ~BrokerProcess() = default;
    BrokerProcess(const BrokerProcess&) = delete;
    BrokerProcess& operator=(const BrokerProcess&) = delete;

    void start();
    /// kill -9.
    void crash();
    /// SIGSTOP and SIGCONT.
    void stop();
    void go_on();
    /// The core's thread gets no processor, or its turn does not end, until go_on().
    void stop_core();

    [[nodiscard]] const std::string& name() const { return name_; }
    [[nodiscard]] Node node() const { return node_; }
    [[nodiscard]] bool is_up() const { return up_; }
    [[nodiscard]] bool is_stopped() const { return stopped_; }  // or its core alone
    [[nodiscard]] bool is_running() const { return up_ && !stopped_; }
    [[nodiscard]] const LocalClock& clock() const { return clock_; }
    /// Counts the starts.
    [[nodiscard]] std::uint64_t incarnation() const { return incarnation_; }

protected:
    struct Datagram {
        Endpoint via;
        Endpoint from;
        std::vector<std::uint8_t> octets;
    };

    virtual void create_core() = 0;
    virtual void destroy_core() = 0;
    virtual void take(const Datagram& datagram) = 0;
    virtual void take(const cluster::Envelope& envelope) = 0;
    virtual void tick() = 0;
    /// In the machine's own time.
    [[nodiscard]] virtual Instant next_wakeup() const = 0;
    virtual void on_stop() {}
    virtual void on_stop_core() {}
    virtual void on_go_on() {}

    /// For the subclass: sockets, time, and what came from peers.
    void bind(const Endpoint& address);
    /// With what came there and was not read.
    void unbind(const Endpoint& address);
    [[nodiscard]] bool is_serving(const Endpoint& address) const {
        return bound_.contains(address);
    }
    void send(const Endpoint& via, const Endpoint& to, Bytes datagram);
    void on_envelope(const cluster::Envelope& envelope);
    [[nodiscard]] Instant local_now() const { return clock_.at(events_.now()); }
    void rearm();
    /// Runs `action` later, unless this start of the process has ended by then; while it is stopped
    /// the action waits.
    void later(Duration delay, EventQueue::Event action);

    EventQueue& events_;
    Trace& trace_;
    Random random_;

private:
    void run_backlog();

    static constexpr std::size_t socket_buffer = 200;  // datagrams that a stopped process keeps

    std::string name_;
    Node node_;
    ClientNetwork& clients_;
    LocalClock clock_;
    Duration turn_;
    bool up_ = false;
    bool stopped_ = false;
    std::uint64_t incarnation_ = 0;
    Instant timer_ = never;  // in virtual time
    Instant ticked_at_ = Instant::min();
    std::map<Endpoint, ClientNetwork::Binding> bound_;
    std::deque<Datagram> datagrams_;  // while stopped
    std::vector<cluster::Envelope> envelopes_;
    std::vector<EventQueue::Event> postponed_;
};

}  // namespace romano::sim
