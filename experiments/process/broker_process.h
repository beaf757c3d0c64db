// A real broker process under the sweep's control. It never outlives the sweep: the kernel kills
// it when its parent dies, the destructor when it goes out of scope.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace romano::experiments {

class BrokerProcess {
public:
    /// Starts `program`; what it prints goes to `trace`. Throws std::runtime_error when it cannot
    /// be started. PR_SET_PDEATHSIG watches the starting thread: start from one that stays.
    BrokerProcess(std::string name, const std::filesystem::path& program,
                  const std::vector<std::string>& arguments, std::filesystem::path trace);
    ~BrokerProcess();
    BrokerProcess(const BrokerProcess&) = delete;
    BrokerProcess& operator=(const BrokerProcess&) = delete;

    [[nodiscard]] const std::string& name() const { return name_; }
    [[nodiscard]] pid_t pid() const { return pid_; }

    /// kill -9: no farewell. The process is gone when this returns.
    void kill();
    void pause();        // SIGSTOP
    void resume();       // SIGCONT
    void ask_to_stop();  // SIGTERM, also to a paused process
    /// Asks, and kills if it has not ended within `patience`.
    void stop(std::chrono::milliseconds patience);

    /// True once the process has ended, for whatever reason.
    [[nodiscard]] bool has_ended();
    /// "exit code 2", "signal 11 (Segmentation fault)", with the last line of its trace.
    [[nodiscard]] std::string how_it_ended() const;
    /// Throws std::runtime_error with that when it has ended.
    void expect_running();

private:
    void reap(int options);

    std::string name_;
    std::filesystem::path trace_;
    pid_t pid_ = -1;
    std::optional<int> wait_status_;
};

}  // namespace romano::experiments
