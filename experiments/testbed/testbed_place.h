// Where the brokers of a sweep live on a testbed: the first broker at the first address of the
// first host, the next at that of the next host, and so on; then the hosts' second addresses.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "experiments/sweep/manifest.h"
#include "experiments/sweep/sweep_file.h"
#include "experiments/testbed/examination.h"
#include "experiments/testbed/hosts_file.h"

namespace romano::experiments {

struct Seat {
    std::size_t host = 0;  // in the hosts file
    std::string address;
};
[[nodiscard]] std::vector<Seat> seats_of(const Testbed& testbed);

class TestbedPlace {
public:
    /// Looks at the machines first. Throws SettingError when one has a problem, or when the cells
    /// need more; `tell` hears what is going on, and warnings.
    TestbedPlace(const std::filesystem::path& hosts_file, const SweepSettings& settings,
                 const std::vector<Cell>& cells,
                 const std::function<void(const std::string&)>& tell);

    [[nodiscard]] const Testbed& testbed() const { return testbed_; }
    [[nodiscard]] const Connections& connections() const { return connections_; }
    [[nodiscard]] const std::vector<Seat>& seats() const { return seats_; }
    [[nodiscard]] const std::string& broker_version() const { return broker_version_; }
    /// For the report.
    [[nodiscard]] const std::vector<BrokerHost>& hosts() const { return hosts_; }
    /// hosts.toml and hosts.json, into the results. Throws SettingError when they are of other
    /// hosts.
    void leave_word(const std::filesystem::path& results, bool fresh) const;

private:
    Testbed testbed_;
    Connections connections_{testbed_};
    std::vector<Seat> seats_;
    std::string broker_version_;
    std::vector<BrokerHost> hosts_;
    nlohmann::json seen_;
};

/// Results of a testbed stand beside those of this machine: "results/demo-on-hosts".
[[nodiscard]] std::filesystem::path output_on(const std::filesystem::path& output,
                                              const std::filesystem::path& hosts_file);

}  // namespace romano::experiments
