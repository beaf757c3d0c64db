#include "experiments/sweep/cell_keys.h"

#include <stdlib.h>

#include <algorithm>
#include <fstream>
#include <system_error>

#include "experiments/robots/failover_probe.h"
#include "experiments/robots/swarm.h"
#include "experiments/sweep/cell_brokers.h"
#include "experiments/sweep/cell_world.h"
#include "romano/keys/key_error.h"

namespace romano::experiments {
namespace {

namespace fs = std::filesystem;

fs::path new_folder() {
    std::error_code none;
    const fs::path memory = "/dev/shm";
    const fs::path place = fs::is_directory(memory, none) ? memory : fs::temp_directory_path(none);
    std::string name = (place / "romano-keys-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) throw RunFailed("no folder for keys: " + name);
    return name;
}

}  // namespace

CellKeys::CellKeys(const SweepSettings& settings, const Cell& cell)
    : speech_(cell.clients == "dtls" ? keys::Speech::dtls : keys::Speech::packets),
      folder_(new_folder()),
      keys_(folder_ / "fleet") {
    keys::Names names;
    for (std::size_t i = 0; i < cell.brokers; ++i) {
        names.brokers.push_back(CellBrokers::name_of(i));
        watchers_.push_back(CellBrokers::watch_of(i));
        for (const std::string& id : FailoverProbe::client_ids_at(i)) names.robots.push_back(id);
    }
    const Traffic traffic(settings.pattern, cell.robots, settings.group, cell.qos);
    for (RobotNumber number = 0; number < traffic.clients(); ++number) {
        names.robots.push_back(Swarm::client_id_of(number));
    }
    names.operators = watchers_;
    try {
        keys_.add(names);
    } catch (const keys::KeyError& error) {
        throw RunFailed(error.what());
    }
    std::ofstream(folder_ / "rights")
        << "group robots\ntopic readwrite #\n\ngroup operators\ntopic read $SYS/#\n";
}

CellKeys::~CellKeys() {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
}

std::vector<std::string> CellKeys::broker_arguments(const std::string& broker) const {
    return {"--keys", keys_.broker_folder(broker), "--rights", folder_ / "rights"};
}

std::shared_ptr<keys::ClientPackets> CellKeys::packets_of(const std::string& client_id) const {
    const bool watches = std::ranges::find(watchers_, client_id) != watchers_.end();
    try {
        return std::make_shared<keys::ClientPackets>(
            keys_.own_file(client_id, watches ? keys::Role::person : keys::Role::robot), client_id,
            speech_);
    } catch (const keys::KeyError& error) {
        throw RunFailed(error.what());
    }
}

}  // namespace romano::experiments
