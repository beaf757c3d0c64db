// romano-broker: a broker alone; with --domain it becomes romano-broker-member,
// with --uplink romano-broker-uplink.

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>

#include "broker/daemon/lone_broker.h"
#include "broker/daemon/program.h"
#include "broker/daemon/refusal.h"

namespace {

using namespace romano::daemon;

/// The same process goes on as the program of that name beside this one.
[[noreturn]] void become(const char* name, char** argv) {
    std::error_code unknown;
    const auto self = std::filesystem::read_symlink("/proc/self/exe", unknown);
    const std::string path = self.parent_path() / name;
    execv(path.c_str(), argv);
    throw Refusal("this needs the program " + path + ", which cannot be started (" +
                  std::strerror(errno) + "); install it beside romano-broker");
}

}  // namespace

int main(int argc, char** argv) {
    return run_program(argc, argv,
                       {.prepare =
                            [argv](const Settings& settings) {
                                if (settings.uplink) become("romano-broker-uplink", argv);
                                if (settings.cluster) become("romano-broker-member", argv);
                            },
                        .start =
                            [](boost::asio::io_context& io, const Settings& settings,
                               const OnServing& on_serving) {
                                return std::make_unique<LoneBroker>(io, settings, on_serving);
                            }});
}
