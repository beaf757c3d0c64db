// The programs that a testbed runs on this machine: brokers, and robots. When this goes, all of
// them are gone, and the service addresses that they had taken are off the machine.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "experiments/process/broker_process.h"
#include "experiments/process/process_usage.h"
#include "experiments/testbed/program_order.h"

namespace romano::experiments {

struct EndedLife {
    std::uint32_t number;
    std::uint32_t life;
    std::string how;
};

struct UsedByLife {
    std::uint32_t number;
    std::uint32_t life;
    ProcessUsage usage;
};

class HostBrokers {
public:
    /// Traces are kept in `traces`; `programs` is the folder with the programs; `addresses` are all
    /// that brokers of the testbed may take.
    HostBrokers(std::filesystem::path programs, std::filesystem::path traces,
                std::vector<std::string> addresses);
    ~HostBrokers();
    HostBrokers(const HostBrokers&) = delete;
    HostBrokers& operator=(const HostBrokers&) = delete;

    /// In the place of an earlier life. When it cannot be started, it has ended.
    void start(const ProgramOrder& order);
    void kill(std::uint32_t number);
    void pause(std::uint32_t number);
    void resume(std::uint32_t number);
    void ask_to_stop(std::uint32_t number);
    /// All are asked, and killed when they have not ended in two seconds. No address stays.
    void stop_all();

    /// How those ended that have ended since the last look.
    [[nodiscard]] std::vector<EndedLife> look();
    [[nodiscard]] std::vector<UsedByLife> usage() const;
    /// What each life has printed, by the name of its file; at most the last 4 MiB of each.
    [[nodiscard]] std::map<std::string, std::string> traces() const;
    /// The pages of those that run, by the same names.
    [[nodiscard]] std::map<std::string, std::string> metrics() const;
    /// Keeps the leases, if called each second.
    void renew_leases();

private:
    struct Life {
        ProgramOrder order;
        std::unique_ptr<BrokerProcess> process;  // null: it could not be started
        std::string trouble;
        bool is_told = false;  // that it has ended
    };

    [[nodiscard]] BrokerProcess* running(std::uint32_t number);
    void remove_addresses() const;

    std::filesystem::path programs_;
    std::filesystem::path traces_;
    std::vector<std::string> addresses_;
    std::map<std::uint32_t, Life> lives_;
    std::vector<std::string> trace_names_;
};

/// Addresses that nobody serves any more, left by brokers that were killed, go at once.
void forget_addresses(const std::vector<std::string>& addresses);

}  // namespace romano::experiments
