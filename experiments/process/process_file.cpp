#include "experiments/process/process_file.h"

#include <fstream>
#include <sstream>

namespace romano::experiments {

std::string process_file(pid_t pid, const std::string& name) {
    std::ifstream stream("/proc/" + std::to_string(pid) + "/" + name);
    return process_file(stream);
}

std::string process_file(std::istream& opened) {
    std::ostringstream text;
    text << opened.rdbuf();  // an istreambuf_iterator throws when the process is gone (ESRCH)
    return text.str();
}

}  // namespace romano::experiments
