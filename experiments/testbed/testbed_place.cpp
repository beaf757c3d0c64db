#include "experiments/testbed/testbed_place.h"

#include <algorithm>

#include "experiments/sweep/text_file.h"

namespace romano::experiments {
namespace {

/// A sweep has its robots here.
Testbed brokers_alone(Testbed testbed) {
    std::erase_if(testbed.hosts, [](const Host& host) { return host.role == HostRole::robots; });
    return testbed;
}

/// What a sweep cannot do without, beside what the doctor says.
void refuse_what_is_missing(const Testbed& testbed, const std::vector<HostSeen>& seen,
                            const std::vector<Cell>& cells, std::size_t seats) {
    const auto brokers = std::ranges::max(cells, {}, &Cell::brokers).brokers;
    if (brokers > seats) {
        throw SettingError("the sweep has cells of " + std::to_string(brokers) +
                           " brokers, and the hosts file has " + std::to_string(seats) +
                           " addresses for them; give more, or make `brokers` less");
    }
    const bool cuts =
        std::ranges::any_of(cells, [](const Cell& cell) { return cell.fault == Fault::cut; });
    for (std::size_t i = 0; i < testbed.hosts.size(); ++i) {
        if (!seen[i].facts) continue;
        if (!seen[i].facts->taken_by.empty()) {
            throw SettingError(testbed.hosts[i].name + " is taken by " + seen[i].facts->taken_by +
                               "; romano testbed stop HOSTS, or wait for that sweep");
        }
        if (cuts && !seen[i].facts->may_cut) {
            throw SettingError("fault `cut` is not possible at " + testbed.hosts[i].name +
                               " without nft; there: sudo apt install nftables");
        }
    }
}

}  // namespace

std::vector<Seat> seats_of(const Testbed& testbed) {
    std::vector<Seat> seats;
    for (std::size_t turn = 0;; ++turn) {
        const std::size_t before = seats.size();
        for (std::size_t i = 0; i < testbed.hosts.size(); ++i) {
            const auto& addresses = testbed.hosts[i].addresses;
            if (turn < addresses.size()) seats.push_back({i, addresses[turn]});
        }
        if (seats.size() == before) return seats;
    }
}

TestbedPlace::TestbedPlace(const std::filesystem::path& hosts_file, const SweepSettings& settings,
                           const std::vector<Cell>& cells,
                           const std::function<void(const std::string&)>& tell)
    : testbed_(brokers_alone(read_hosts(hosts_file))), seats_(seats_of(testbed_)) {
    const auto seen = examine(testbed_, connections_, settings.port, tell);
    const auto findings = findings_of(testbed_, seen, own_version());
    if (has_problem(findings)) {
        throw SettingError("the hosts are not ready, see romano testbed check:\n" +
                           to_text(findings));
    }
    refuse_what_is_missing(testbed_, seen, cells, seats_.size());
    for (const HostFinding& warning : findings) tell(warning.host + ": " + warning.sentence);
    seen_ = to_json(testbed_, seen, findings);
    broker_version_ = seen[seats_.front().host].facts->broker_version;
    for (std::size_t i = 0; i < testbed_.hosts.size(); ++i) {
        hosts_.push_back({.name = testbed_.hosts[i].name,
                          .addresses = testbed_.hosts[i].addresses,
                          .architecture = seen[i].facts->architecture,
                          .broker_version = seen[i].facts->broker_version});
    }
}

void TestbedPlace::leave_word(const std::filesystem::path& results, bool fresh) const {
    const auto file = results / "hosts.toml";
    if (!fresh && std::filesystem::exists(file) && read_text(file) != testbed_.text) {
        throw SettingError("`" + results.string() +
                           "` has results of another hosts file, kept there as hosts.toml; use "
                           "that one, or --fresh, which deletes them");
    }
    write_text(file, testbed_.text);
    write_text(results / "hosts.json", seen_.dump(2) + "\n");
}

std::filesystem::path output_on(const std::filesystem::path& output,
                                const std::filesystem::path& hosts_file) {
    std::filesystem::path on = output;
    on += "-on-" + hosts_file.stem().string();
    return on;
}

}  // namespace romano::experiments
