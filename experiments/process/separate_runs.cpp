#include "experiments/process/separate_runs.h"

#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <exception>
#include <fstream>
#include <iterator>
#include <map>
#include <stdexcept>

namespace romano::experiments {
namespace {

std::filesystem::path file_of(const std::string& name, const std::filesystem::path& folder) {
    return folder / (name + ".csv");
}

/// The file appears whole or not at all.
void leave_outcome(const SeparateRun& run, const std::filesystem::path& folder) {
    const auto partial = folder / (run.name + ".part");
    std::ofstream file(partial);
    file << run.outcome();
    file.close();
    if (!file) throw std::runtime_error("cannot write `" + partial.string() + "`");
    std::filesystem::rename(partial, file_of(run.name, folder));
}

pid_t begin(const SeparateRun& run, const std::filesystem::path& folder) {
    const pid_t parent = ::getpid();
    const pid_t child = ::fork();
    if (child < 0) throw std::runtime_error("cannot start another process");
    if (child > 0) return child;
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);  // nobody goes on for a caller that is gone
    int exit_code = ::getppid() == parent ? 0 : 1;
    try {
        if (exit_code == 0) leave_outcome(run, folder);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "romano: %s: %s\n", run.name.c_str(), error.what());
        exit_code = 1;
    }
    ::_exit(exit_code);
}

}  // namespace

bool is_done(const SeparateRun& run, const std::filesystem::path& folder) {
    return std::filesystem::exists(file_of(run.name, folder));
}

void do_runs(const std::vector<SeparateRun>& runs, const std::filesystem::path& folder,
             unsigned jobs, const std::function<void(const SeparateRun&)>& done) {
    std::map<pid_t, const SeparateRun*> running;
    bool failed = false;
    const auto await_one = [&] {
        int status = 0;
        const auto ended = running.find(::wait(&status));
        if (ended == running.end()) throw std::runtime_error("the process of a run is gone");
        if (status == 0) {
            done(*ended->second);
        } else {
            failed = true;
        }
        running.erase(ended);
    };
    for (const SeparateRun& run : runs) {
        if (failed) break;
        if (is_done(run, folder)) continue;
        const bool is_one_alone =
            run.is_in_real_time || (!running.empty() && running.begin()->second->is_in_real_time);
        while (running.size() >= (is_one_alone ? 1 : jobs)) await_one();
        running.emplace(begin(run, folder), &run);
    }
    while (!running.empty()) await_one();
    if (failed) {
        throw std::runtime_error("a run failed; what was done before is kept in `" +
                                 folder.string() + "`");
    }
}

std::string outcome_of(const std::string& name, const std::filesystem::path& folder) {
    std::ifstream file(file_of(name, folder));
    return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace romano::experiments
