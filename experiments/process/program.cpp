#include "experiments/process/program.h"

#include <unistd.h>

#include <boost/process/args.hpp>
#include <boost/process/child.hpp>
#include <boost/process/exe.hpp>
#include <boost/process/extend.hpp>
#include <boost/process/io.hpp>
#include <boost/process/pipe.hpp>
#include <boost/process/start_dir.hpp>
#include <cstdlib>
#include <iterator>
#include <sstream>
#include <system_error>

namespace romano::experiments {
namespace {

namespace process = boost::process;

/// Empty when nothing of that name may be executed. (Boost's own search would bring the library
/// Boost.Filesystem.)
std::string found_on_path(const std::string& program) {
    if (program.find('/') != std::string::npos) return program;
    const char* path = std::getenv("PATH");
    std::istringstream folders(path == nullptr ? "/usr/sbin:/usr/bin:/sbin:/bin" : path);
    for (std::string folder; std::getline(folders, folder, ':');) {
        const std::string candidate = folder + "/" + program;
        if (::access(candidate.c_str(), X_OK) == 0) return candidate;
    }
    return {};
}

}  // namespace

ProgramEnd run_program(const std::string& program, const std::vector<std::string>& arguments,
                       const std::filesystem::path& folder) {
    ProgramEnd end;
    const std::string file = found_on_path(program);
    if (file.empty()) return end;
    process::ipstream output;
    std::error_code failed;
    process::child child(
        process::exe = file, process::args = arguments,
        process::std_in<process::null, process::std_out> output, process::std_err > process::null,
        process::start_dir = folder.empty() ? std::string{"."} : folder.string(),
        process::extend::on_exec_setup =
            [](auto&) { (void)::close_range(3, ~0U, CLOSE_RANGE_CLOEXEC); },
        failed);
    if (failed) return end;
    end.output.assign(std::istreambuf_iterator<char>(output), {});
    child.wait(failed);
    if (!failed) end.exit_code = child.exit_code();
    return end;
}

}  // namespace romano::experiments
