// Whom a bench measures: a program that carries messages, running as a process of its own, and the
// clients that speak its protocol.
#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bench/fleet.h"
#include "bench/flood.h"
#include "experiments/load/client_sockets.h"
#include "experiments/load/load_clients.h"
#include "experiments/load/load_plan.h"
#include "experiments/process/broker_process.h"
#include "romano/base/endpoint.h"

namespace romano::bench {

enum class Kind { reflector, broker, mosquitto, other };

/// Who takes part, under which name.
struct Entrant {
    Kind kind;
    std::string name;
    std::optional<Endpoint> address = {};  // of another MQTT-SN broker, which runs already
    Endpoint::Packets packets = Endpoint::Packets::plain;  // of our broker's listener
    bool has_keys = false;  // at a plain listener: clients of that broker, though none of the load
    std::optional<Forgery> forgery = {};  // of a stranger, while the load goes on
    bool has_cell = false;  // subscribers listen to a multicast group (romano/mqttsn/cell.md)
};

/// Of a process. What files it has in memory other processes share: each has its part of the
/// proportional octets, and all of the resident ones.
struct Memory {
    double resident_kib = std::numeric_limits<double>::quiet_NaN();
    double proportional_kib = std::numeric_limits<double>::quiet_NaN();
    double anonymous_kib = std::numeric_limits<double>::quiet_NaN();  // in no file: its own alone
};

class Contestant {
public:
    /// Starts the program on a free address of 127.40.0.0/16, on a core of its own if there is one;
    /// or takes the other broker as it runs, of whose process nothing is known. So many clients
    /// have keys where keys are needed.
    Contestant(Entrant entrant, std::uint32_t clients);
    ~Contestant();

    [[nodiscard]] std::unique_ptr<experiments::LoadClients> clients(
        const experiments::LoadPlan& plan, experiments::SocketUse sockets) const;

    /// CPU time in seconds that it has used so far, all threads. NaN of another broker.
    [[nodiscard]] double cpu_s() const;
    /// Now. NaN of another broker.
    [[nodiscard]] Memory memory() const;
    /// Throws std::runtime_error when it has ended by itself.
    void check();

private:
    [[nodiscard]] std::string cell_group() const;

    Entrant entrant_;
    std::string host_;
    int port_ = 0;
    std::optional<Fleet> fleet_;  // where keys are needed
    std::unique_ptr<experiments::BrokerProcess> process_;
};

/// This process, which is the load generator, takes the first core that it may use and leaves the
/// second to the contestants; and it goes before what else runs here, if it may (contestants, its
/// children, likewise).
void take_first_core();

}  // namespace romano::bench
