// The sessions of a lone broker in a file, so that they outlive its process.
//
// The broker core writes a log; here each event becomes changes of rows, and a batch of them one
// transaction: what it promises to clients may leave when keep() has returned true. At the start
// load() gives back what a dead broker's mirror would. One file belongs to one process at a time.
#pragma once

#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>

#include "broker/core/actions.h"
#include "broker/core/broker_core.h"
#include "broker/store/stored_state.h"

namespace romano::store {

/// Why a file cannot be the store, as the end of a sentence. The file is as it was.
class StoreRefusal : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

struct StoreOptions {
    std::string path;
    std::uint64_t most_octets = 1ULL << 30U;  // of the file; beyond it nothing can be kept
    /// Each batch reaches the medium before it is promised: outlives a power cut too, not only the
    /// end of the process.
    bool survives_power_cut = false;
};

class SessionStore {
public:
    /// Throws StoreRefusal.
    explicit SessionStore(const StoreOptions& options);
    ~SessionStore();

    /// Throws StoreRefusal.
    [[nodiscard]] StoredState load(broker::BrokerId self);
    /// The broker's log must have a higher incarnation.
    [[nodiscard]] std::uint64_t last_incarnation();

    /// From here on events of this log may be kept.
    void begin_log(const broker::LogId& log);

    /// Keeps all Appends. False: none of them is in the file, and problem() says why.
    [[nodiscard]] bool keep(const broker::Actions& actions);
    /// Keeps the broker's state as it is now instead of all that was there.
    [[nodiscard]] bool keep_all(const broker::BrokerCore& broker);
    [[nodiscard]] const std::string& problem() const { return problem_; }

private:
    class Open;
    template <typename Write>
    bool in_transaction(Write&& write);

    std::unique_ptr<Open> open_;
    std::string problem_;
};

}  // namespace romano::store
