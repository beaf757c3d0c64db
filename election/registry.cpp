// Electors and detectors by the names that configuration uses.

#include <algorithm>
#include <array>

#include "election/bully.h"
#include "election/component.h"
#include "election/elector.h"
#include "election/failure_detector.h"
#include "election/fixed.h"
#include "election/link.h"
#include "election/phi_accrual.h"
#include "election/raft.h"

namespace romano::election {
namespace {

template <typename Interface, typename Options>
struct Entry {
    std::string_view name;
    std::unique_ptr<Interface> (*make)(const Options&);
};

template <typename Implementation, typename Interface, typename Options>
std::unique_ptr<Interface> make(const Options& options) {
    return std::make_unique<Implementation>(options);
}

constexpr std::array electors = {
    Entry<Elector, ElectorOptions>{"component", make<ComponentElector, Elector, ElectorOptions>},
    Entry<Elector, ElectorOptions>{"raft", make<RaftElector, Elector, ElectorOptions>},
    Entry<Elector, ElectorOptions>{"bully", make<BullyElector, Elector, ElectorOptions>},
};
constexpr std::array detectors = {
    Entry<FailureDetector, DetectorOptions>{"fixed",
                                            make<FixedDetector, FailureDetector, DetectorOptions>},
    Entry<FailureDetector, DetectorOptions>{
        "phi-accrual", make<PhiAccrualDetector, FailureDetector, DetectorOptions>},
    Entry<FailureDetector, DetectorOptions>{"link",
                                            make<LinkDetector, FailureDetector, DetectorOptions>},
};

template <typename Table>
constexpr auto names_of(const Table& table) {
    std::array<std::string_view, std::tuple_size_v<Table>> names{};
    std::ranges::transform(table, names.begin(), [](const auto& entry) { return entry.name; });
    return names;
}
constexpr auto names_of_electors = names_of(electors);
constexpr auto names_of_detectors = names_of(detectors);

}  // namespace

std::unique_ptr<Elector> make_elector(std::string_view name, const ElectorOptions& options) {
    for (const auto& entry : electors) {
        if (entry.name == name) return entry.make(options);
    }
    return nullptr;
}

std::span<const std::string_view> elector_names() {
    return names_of_electors;
}

std::unique_ptr<FailureDetector> make_detector(std::string_view name,
                                               const DetectorOptions& options) {
    for (const auto& entry : detectors) {
        if (entry.name == name) return entry.make(options);
    }
    return nullptr;
}

std::span<const std::string_view> detector_names() {
    return names_of_detectors;
}

}  // namespace romano::election
