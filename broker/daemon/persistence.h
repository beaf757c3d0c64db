// A lone broker's memory that outlives it (--store): nothing that was promised leaves before its
// events are in the file.
//
// When the file cannot be written (the disk is full), said once: what was not kept is not promised,
// clients that ask for a new promise hear "congestion", QoS 0 goes on. Every two seconds the whole
// state is tried anew; when that succeeds, all is as before.
#pragma once

#include <boost/asio/io_context.hpp>

#include "broker/core/broker_core.h"
#include "broker/daemon/settings.h"
#include "broker/metrics/page.h"
#include "broker/net/core_timer.h"
#include "broker/store/session_store.h"

namespace romano::daemon {

class Persistence {
public:
    /// Throws Refusal.
    Persistence(boost::asio::io_context& io, const StoreSettings& settings);

    /// A log incarnation that is higher than all before; `wall_clock` unless it went back.
    [[nodiscard]] std::uint64_t next_incarnation(std::uint64_t wall_clock);
    /// Gives the core back what the file holds, and keeps what comes of it. Throws Refusal.
    void restore(Instant now, broker::BrokerCore& core, const broker::LogId& log,
                 broker::Actions& out);

    /// Keeps the events among the actions, and takes out of them what cannot be promised.
    void keep(broker::BrokerCore& core, broker::Actions& actions);

    void add_metrics(metrics::Page& page) const;

private:
    void suspend(broker::BrokerCore& core);
    void try_again();

    std::string path_;
    store::SessionStore store_;
    broker::BrokerCore* core_ = nullptr;
    broker::Seq kept_through_ = 0;
    bool is_keeping_ = true;
    std::uint64_t batches_ = 0;
    std::uint64_t failures_ = 0;
    net::CoreTimer retry_;
};

}  // namespace romano::daemon
