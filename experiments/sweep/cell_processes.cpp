#include "experiments/sweep/cell_processes.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <exception>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "experiments/sweep/csv.h"

namespace romano::experiments {
namespace {

constexpr int look_every_ms = 100;

// What a run says through its pipe: lines "p0.25 load", and as its last word 'r' and its row.
constexpr char progress_mark = 'p';
constexpr char row_mark = 'r';

void write_all(int pipe, std::string_view text) {
    while (!text.empty()) {
        const ssize_t written = ::write(pipe, text.data(), text.size());
        if (written <= 0) ::_exit(1);  // nobody listens any more
        text.remove_prefix(static_cast<std::size_t>(written));
    }
}

/// A run under way, as its parent sees it.
class Run {
public:
    Run(const Cell& cell, const CellProcesses& processes) : cell_(cell) {
        std::array<int, 2> ends{};
        if (::pipe2(ends.data(), O_CLOEXEC) != 0) throw std::runtime_error("no pipe for a run");
        std::fflush(nullptr);  // or the child would print it again
        const pid_t parent = ::getpid();
        pid_ = ::fork();
        if (pid_ < 0) throw std::runtime_error("cannot start a process for a run");
        if (pid_ == 0) {
            ::prctl(PR_SET_PDEATHSIG, SIGKILL);  // nobody goes on for a caller that is gone
            if (::getppid() != parent) ::_exit(1);
            ::close(ends[0]);
            be_the_run(cell, processes, ends[1]);
        }
        ::close(ends[1]);
        pipe_ = ends[0];
    }
    ~Run() {
        if (pipe_ < 0) return;
        ::kill(pid_, SIGKILL);
        await_end();
    }
    Run(Run&& other) noexcept
        : cell_(std::move(other.cell_)),
          pid_(other.pid_),
          pipe_(std::exchange(other.pipe_, -1)),
          said_(std::move(other.said_)),
          share_(other.share_),
          doing_(std::move(other.doing_)) {}
    Run& operator=(Run&& other) noexcept {
        std::swap(cell_, other.cell_);
        std::swap(pid_, other.pid_);
        std::swap(pipe_, other.pipe_);
        std::swap(said_, other.said_);
        std::swap(share_, other.share_);
        std::swap(doing_, other.doing_);
        return *this;
    }

    [[nodiscard]] int pipe() const { return pipe_; }
    [[nodiscard]] double share() const { return share_; }
    [[nodiscard]] std::string what() const { return describe(cell_) + ": " + doing_; }

    /// Hears what it said. Its row when it has ended.
    std::optional<RunRow> listen() {
        std::array<char, 4096> octets{};
        const ssize_t size = ::read(pipe_, octets.data(), octets.size());
        if (size < 0 && errno == EINTR) return std::nullopt;
        if (size > 0) {
            said_.append(octets.data(), static_cast<std::size_t>(size));
            take_progress();
            return std::nullopt;
        }
        const int status = await_end();
        if (said_.starts_with(row_mark)) {
            for (const CsvRow& fields : parse_csv(said_.substr(1))) {
                if (auto row = run_from_csv(fields)) return row;
            }
        }
        RunRow row;
        row.cell = cell_;
        row.status = WIFSIGNALED(status) ? "the run's process was ended by signal " +
                                               std::to_string(WTERMSIG(status))
                                         : "the run's process ended without a row";
        return row;
    }

private:
    [[noreturn]] static void be_the_run(const Cell& cell, const CellProcesses& processes,
                                        int pipe) {
        try {
            const RunRow row = processes.run(cell, [pipe](double share, std::string_view doing) {
                write_all(pipe,
                          progress_mark + std::to_string(share) + ' ' + std::string{doing} + '\n');
            });
            write_all(pipe, row_mark + csv_line(to_csv(row)));
            ::_exit(0);
        } catch (const std::exception& error) {
            std::fprintf(stderr, "romano sweep: cell %u: %s\n", cell.number, error.what());
            ::_exit(1);
        }
    }

    void take_progress() {
        while (said_.starts_with(progress_mark)) {
            const std::size_t end = said_.find('\n');
            if (end == std::string::npos) return;
            const std::string line = said_.substr(1, end - 1);
            const std::size_t blank = line.find(' ');
            share_ = std::stod(line);
            doing_ = line.substr(blank + 1);
            said_.erase(0, end + 1);
        }
    }

    int await_end() {
        ::close(std::exchange(pipe_, -1));
        int status = 0;
        while (::waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
        }
        return status;
    }

    Cell cell_;
    pid_t pid_ = -1;
    int pipe_ = -1;  // -1: it has ended
    std::string said_;
    double share_ = 0;
    std::string doing_ = "begins";
};

}  // namespace

bool CellProcesses::run_all(std::span<const Cell> cells) const {
    std::vector<Run> runs;
    while (!cells.empty() || !runs.empty()) {
        if (is_interrupted()) return false;
        while (!cells.empty() && runs.size() < at_once) {
            runs.emplace_back(cells.front(), *this);
            cells = cells.subspan(1);
        }
        std::vector<pollfd> pipes;
        for (const Run& one : runs) pipes.push_back({one.pipe(), POLLIN, 0});
        if (::poll(pipes.data(), pipes.size(), look_every_ms) < 0) continue;  // a signal
        for (std::size_t i = runs.size(); i-- > 0;) {
            if (pipes[i].revents == 0) continue;
            const auto row = runs[i].listen();
            if (!row) continue;
            // Ctrl-C comes to all: who ended without a row may have been told to.
            if (is_interrupted()) return false;
            on_row(*row);
            runs.erase(runs.begin() + static_cast<std::ptrdiff_t>(i));
        }
        double share = 0;
        for (const Run& one : runs) share += one.share();
        if (!runs.empty()) {
            on_progress(share, (runs.size() > 1 ? std::to_string(runs.size()) + " cells at once, " +
                                                      "the first: "
                                                : "") +
                                   runs.front().what());
        }
    }
    return true;
}

}  // namespace romano::experiments
