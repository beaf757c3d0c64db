// How long a broker's address is without service, measured finer than robots can: at each broker a
// publisher and a subscriber of their own, with a message of QoS 0 every few milliseconds from one
// to the other. Its messages stand in no books but these.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "experiments/robots/robot_client.h"

namespace romano::experiments {

class FailoverProbe {
public:
    FailoverProbe(Surroundings& surroundings, const std::vector<BrokerAddress>& brokers,
                  double rate_per_s, Duration retry, std::uint64_t seed);
    ~FailoverProbe();

    /// Of the publisher and the subscriber there.
    [[nodiscard]] static std::array<std::string, 2> client_ids_at(std::size_t broker);

    void join();
    [[nodiscard]] bool has_joined() const;
    /// Why joining cannot end well.
    [[nodiscard]] const std::optional<std::string>& trouble() const { return trouble_; }

    void start();
    void stop();
    void leave();

    /// From `strike` to the first message that was published after it and arrived; empty when none
    /// did.
    [[nodiscard]] std::optional<Duration> failover(std::size_t broker, Instant strike) const;

private:
    struct Pair;

    void schedule(Pair& pair);
    void publish_due(Pair& pair);

    Surroundings& surroundings_;
    Duration period_;
    std::vector<std::unique_ptr<Pair>> pairs_;
    bool publishing_ = false;
    std::optional<std::string> trouble_;
};

}  // namespace romano::experiments
