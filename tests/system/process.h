// A real process: started with arguments, watched through its output, killed and reaped in the end
// whatever happens to the test or to the test's own process (PR_SET_PDEATHSIG: the kernel watches
// the thread that starts it, so start from one that stays).
#pragma once

#include <sys/types.h>

#include <chrono>
#include <string>
#include <vector>

namespace romano::system {

class Process {
public:
    Process(const std::string& program, const std::vector<std::string>& arguments);
    ~Process();
    Process(const Process&) = delete;
    Process& operator=(const Process&) = delete;

    /// The next line of stdout without its end; empty when there is none in time.
    [[nodiscard]] std::string next_line(std::chrono::milliseconds limit = default_limit);
    /// Reads lines until one contains `words`; empty when none did in time.
    std::string wait_for(const std::string& words, std::chrono::milliseconds limit = default_limit);
    /// All of stdout that was not read yet, to its end.
    std::string rest_of_output();

    void signal(int number) const;
    /// Waits for the end; -1 when it did not come in time, 128 + signal when killed.
    int wait_for_exit(std::chrono::milliseconds limit = default_limit);
    void kill_9();

    /// What it wrote to stderr so far.
    [[nodiscard]] const std::string& errors();
    [[nodiscard]] pid_t pid() const { return pid_; }

    static constexpr std::chrono::milliseconds default_limit{20'000};

private:
    class Output {
    public:
        explicit Output(int end) : end_(end) {}
        ~Output();
        Output(const Output&) = delete;
        Output& operator=(const Output&) = delete;

        /// Reads what is there, waiting for the first octet; false at the end or in vain.
        bool read(std::chrono::milliseconds limit);
        std::string text;

    private:
        int end_;
    };

    [[nodiscard]] static Output start(const std::string& program,
                                      const std::vector<std::string>& arguments, pid_t& pid,
                                      int& errors_end);

    pid_t pid_ = -1;
    int errors_end_ = -1;
    Output output_;
    Output errors_;
};

}  // namespace romano::system
