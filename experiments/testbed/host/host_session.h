// One ssh connection's say over this machine: JSON objects, one a line, come through the standard
// input and are answered in their order; what happens by itself is told between the answers. When
// the input ends or is silent for ten seconds, everything that was started ends too.
//
// What is said: experiments/testbed/host_channel.h has the other end.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/streambuf.hpp>
#include <chrono>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "experiments/testbed/host/host_brokers.h"
#include "experiments/testbed/host/machine_claim.h"
#include "experiments/testbed/host/multicast_trial.h"
#include "experiments/testbed/host/network_cut.h"

namespace romano::experiments {

class HostSession {
public:
    /// `programs`: the folder with romano-broker.
    HostSession(boost::asio::io_context& io, std::filesystem::path programs, SshPath ssh);
    ~HostSession();

private:
    void read();
    void on_line(const std::string& line);
    void answer(const nlohmann::json& asked);
    /// What a cell needs: nothing of an earlier one is left, and nobody else has the machine.
    void begin(const nlohmann::json& asked);
    void stop();
    void look();
    void say(const nlohmann::json& words);
    void end();

    boost::asio::io_context& io_;
    std::filesystem::path programs_;
    SshPath ssh_;
    boost::asio::posix::stream_descriptor input_;
    boost::asio::streambuf heard_;
    boost::asio::steady_timer timer_;
    int silent_looks_ = 0;
    std::chrono::steady_clock::time_point leases_renewed_;

    std::optional<MachineClaim> claim_;
    std::filesystem::path traces_;  // of this session alone; empty: none yet
    std::string interface_;
    std::unique_ptr<HostBrokers> brokers_;
    bool is_cut_ = false;
    std::unique_ptr<MulticastTrial> trial_;
};

}  // namespace romano::experiments
