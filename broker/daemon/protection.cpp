#include "broker/daemon/protection.h"

#include <spdlog/spdlog.h>

#include <array>
#include <chrono>
#include <system_error>
#include <utility>
#include <vector>

#include "broker/daemon/refusal.h"
#include "romano/keys/client_keys.h"
#include "romano/keys/key_error.h"
#include "romano/keys/key_folder.h"

namespace romano::daemon {
namespace {

namespace fs = std::filesystem;

constexpr std::array<const char*, protection::refusal_kinds> refusal_names = {
    "too_long",       "unstored",       "used_up",   "robot_unheard", "malformed", "unprotected",
    "unknown_scheme", "unknown_sender", "other_run", "replayed",      "bad_tag",   "forwarded"};

fs::file_time_type changed_at(const fs::path& file) {
    std::error_code none;
    return fs::last_write_time(file, none);
}

std::vector<broker::ProtectedClient> clients_of(const keys::ClientKeys& table) {
    std::vector<broker::ProtectedClient> clients;
    for (const auto& [name, owner] : table) {
        for (const std::string& id : keys::client_ids_of(name, owner.role)) {
            clients.push_back({id, keys::key_of(owner, id)});
        }
    }
    return clients;
}

std::vector<rights::KeyOwner> owners_of(const keys::ClientKeys& table) {
    std::vector<rights::KeyOwner> owners;
    for (const auto& [name, owner] : table) {
        owners.push_back(
            {name, owner.role == keys::Role::robot ? rights::Role::robot : rights::Role::person});
    }
    return owners;
}

}  // namespace

std::unique_ptr<Protection> open_protection(const std::optional<std::string>& folder) {
    if (!folder) return nullptr;
    try {
        return std::make_unique<Protection>(*folder);
    } catch (const keys::KeyError& error) {
        throw Refusal("--keys '" + *folder + "': " + error.what());
    }
}

Protection::Protection(fs::path folder)
    : folder_(std::move(folder)),
      lock_(folder_ / "broker.lock"),
      record_(keys::read_broker_record(folder_ / keys::record_name)),
      heard_(folder_ / "clients.heard"),
      clients_(record_.identity, record_.bound) {
    if (!lock_.try_take(0)) {
        throw keys::KeyError(
            "is in use by another broker; each needs a folder of its own "
            "(`romano keys new DIR --broker NAME`)");
    }
    read_table();
    store_bound(0);
    end_storing();
    if (!clients_.reserve().has(clients_.reserve().unused())) {
        throw keys::KeyError(
            "its numbers cannot be stored, or are used up; the broker must be "
            "able to write there");
    }
}

void Protection::read_table() {
    const fs::path table = folder_ / keys::table_name;
    table_of_ = changed_at(table);
    const keys::ClientKeys keys = keys::read_table(table);
    owners_ = owners_of(keys);
    clients_.set_clients(clients_of(keys),
                         [this](const auto& sender) { return heard_.of(sender); });
}

Bytes Protection::admit(const Endpoint& via, const Endpoint& from, Bytes datagram,
                        broker::Actions& out) {
    const Bytes admitted = clients_.admit(via, from, datagram, out);
    if (const auto heard = clients_.to_store()) {
        if (!heard_.add(*heard)) {
            ++unstored_;
            warn("cannot be written, so protected packets are dropped");
            return {};
        }
        clients_.on_stored();
    }
    return admitted;
}

void Protection::seal(broker::Actions& actions) {
    store_bound(actions.list().size());
    clients_.seal(actions);
}

/// Nothing is sealed beyond what is stored. There is a block ahead of the next one to be stored, so
/// that a disk is seldom waited for.
void Protection::store_bound(std::size_t about_to_seal) {
    protection::Reserve& reserve = clients_.reserve();
    if (storing_.valid()) {
        const bool is_stored =
            storing_.wait_for(std::chrono::seconds{0}) == std::future_status::ready;
        const auto last = reserve.unused() + static_cast<std::uint32_t>(about_to_seal);
        if (!is_stored && reserve.has(last)) return;
        end_storing();
    }
    const auto bound = reserve.to_store();
    if (!bound) return;
    record_.bound = *bound;
    storing_ = std::async(std::launch::async,
                          [file = folder_ / keys::record_name, record = record_]() -> std::string {
                              try {
                                  keys::write_broker_record(file, record);
                                  return {};
                              } catch (const keys::KeyError& error) {
                                  return error.what();
                              }
                          });
}

void Protection::end_storing() {
    const std::string error = storing_.get();
    if (error.empty()) {
        clients_.reserve().on_stored(record_.bound);
    } else {
        warn(error);
    }
}

bool Protection::look() {
    if (changed_at(folder_ / keys::table_name) == table_of_) return false;
    try {
        read_table();
        spdlog::info("protected packets: {} clients have keys now", clients_.size());
        return true;
    } catch (const keys::KeyError& error) {
        warn(std::string{error.what()} + "; the keys of before stay");
        return false;
    }
}

void Protection::leave() {
    try {
        heard_.add_all(clients_.heard());
    } catch (const keys::KeyError& error) {
        warn(error.what());
    }
}

void Protection::warn(const std::string& what) {
    if (std::exchange(warned_of_, what) != what) spdlog::warn("{}: {}", folder_.string(), what);
}

void Protection::add_metrics(metrics::Page& page) const {
    const broker::ProtectionCounters counters = clients_.counters();
    page.gauge("romano_protected_clients", "Clients with a key for protected packets.",
               static_cast<double>(clients_.size()));
    const auto packets = [&page](const char* direction, std::uint64_t value) {
        page.counter("romano_protected_packets_total",
                     "Protected packets that were taken, or made.", value,
                     {{"direction", direction}});
    };
    packets("in", counters.opened);
    packets("out", counters.sealed);
    const auto refused = [&page](const char* reason, std::uint64_t value) {
        page.counter("romano_protection_refusals_total",
                     "Datagrams that protection dropped, by reason.", value, {{"reason", reason}});
    };
    for (std::size_t kind = 0; kind < refusal_names.size(); ++kind) {
        refused(refusal_names[kind], counters.refused[kind]);
    }
    refused("foreign_client_id", counters.foreign_client_id);
    refused("needs_protection", counters.needs_protection);
    refused("keyless", counters.keyless);
    refused("not_stored", unstored_);
}

}  // namespace romano::daemon
