// What a load found out, and how people and programs read it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "experiments/load/load_plan.h"
#include "experiments/measure/latency_histogram.h"

namespace romano::experiments {

struct LoadFigures {
    // Of the measured time: after the warm-up, before the drain.
    double measured_s = 0;
    std::uint64_t published = 0;       // messages
    std::uint64_t delivered = 0;       // first copies that came then
    double generator_cpu_percent = 0;  // of one core
    LatencyHistogram latency;          // from when the message was due to its arrival
    LatencyHistogram last_subscriber;  // one a message: until all of its subscribers have it
    LatencyHistogram acknowledgement;  // QoS 1 and 2: to PUBACK or PUBCOMP
    Duration worst_lag{};              // how late the generator itself was, by its schedule

    // Of the whole run.
    std::uint64_t all_published = 0;
    std::uint64_t expected = 0;       // deliveries: a message counts for each of its subscribers
    std::uint64_t all_delivered = 0;  // of these
    std::uint64_t duplicates = 0;
    std::uint64_t out_of_order = 0;
    std::uint64_t strays = 0;           // arrivals where nothing was expected
    std::uint64_t unacknowledged = 0;   // QoS 1 and 2: no answer by the end
    std::uint64_t refused = 0;          // answered with another return code than "accepted"
    std::uint64_t not_taken = 0;        // the client's queue was full, or it had lost its broker
    std::uint64_t retransmissions = 0;  // by our clients
    std::uint64_t marked_dup = 0;       // arrivals that the broker said it sent before
    std::uint64_t dropped_here = 0;     // at our own sockets
    std::optional<std::uint64_t> heard_in_cell;  // datagrams; empty: nobody listens to a cell
    std::uint64_t lost_clients = 0;
    double joined_s = 0;  // until all clients were connected, subscribed and registered
    bool interrupted = false;

    [[nodiscard]] std::uint64_t lost() const { return expected - all_delivered; }
    [[nodiscard]] double published_per_s() const;
    [[nodiscard]] double delivered_per_s() const;
};

[[nodiscard]] std::string text_of(const LoadPlan& plan, const LoadFigures& figures);
[[nodiscard]] std::string json_of(const LoadPlan& plan, const LoadFigures& figures);

}  // namespace romano::experiments
