// Runs the trials: strikes a broker, waits for the first message from the new home, revives the
// victim, waits until all is as before, and again.
#pragma once

#include <boost/asio/io_context.hpp>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "bench/failover/cluster.h"
#include "bench/failover/robots.h"
#include "bench/failover/trial.h"
#include "bench/failover/watched.h"
#include "romano/base/random.h"

namespace romano::bench {

class Bench {
public:
    Bench(boost::asio::io_context& io, const Options& options, const std::filesystem::path& traces);
    ~Bench();

    /// Starts brokers and clients. Throws std::runtime_error when they do not come together.
    void start();
    [[nodiscard]] Trial run(std::uint32_t number);
    /// Full load: publishers and subscribers at all brokers, each message to another broker, the
    /// next one as soon as one has arrived. In the middle the victim is away, if it is to be.
    [[nodiscard]] Watched watch(Duration duration, const std::function<bool()>& is_over);

private:
    [[nodiscard]] std::size_t choose_victim();
    void strike(std::size_t victim);
    void await_whole();
    /// A message that was published at `since` or later reaches the robot.
    std::optional<Instant> await_message(std::size_t robot, Instant since, Duration patience);
    bool run_until(Instant deadline, const std::function<bool()>& done);
    void run_for(Duration duration);
    void publish_on();
    [[nodiscard]] std::shared_ptr<keys::ClientPackets> key_of(std::uint32_t robot) const;

    boost::asio::io_context& io_;
    Options options_;
    std::optional<Fleet> fleet_;  // for clients with keys
    Cluster cluster_;
    Random random_;
    std::vector<std::unique_ptr<Robot>> robots_;  // one a broker
    std::optional<std::size_t> publisher_;        // publishes once a millisecond
    Instant next_publish_{};

    struct Awaited {
        std::size_t robot;
        Instant since;
        std::optional<Instant> arrived;
    };
    std::optional<Awaited> awaited_;
};

}  // namespace romano::bench
